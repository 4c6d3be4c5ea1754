"""Stage `runs`: judges what an embodied arm did."""

from ovman.evaluation import scores as runs
from ovman.workflow.job import job

with job(snakemake) as work:
    arm = work.constants.arm
    runs.run(work.inputs("executions"), work.input("episodes"), work.constants, work.outputs("runs"), arm)
