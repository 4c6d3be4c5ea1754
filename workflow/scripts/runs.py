"""Stage `runs`: judges what an embodied arm did."""

from ovman.evaluation import scores
from ovman.workflow.job import job

with job(snakemake) as work:
    scores.run(work.inputs("executions"), work.input("episodes"), work.outputs("runs"), work.constants.arm)
