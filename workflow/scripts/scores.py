"""Stage `scores`: judges what an embodied arm did."""

from ovman.evaluation import scores
from ovman.workflow.job import job

with job(snakemake) as work:
    scores.run(work.inputs("rollouts"), work.input("episodes"), work.outputs("scores"), work.constants.arm)
