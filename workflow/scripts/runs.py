"""Stage `runs`: judges what an embodied arm did."""

from ovman.agents.arms import Arm
from ovman.analysis import runs
from ovman.job import job

with job(snakemake) as work:
    arm = Arm.of(work.constants.arm)
    runs.run(work.inputs("executions"), work.input("episodes"), work.constants, work.outputs("runs"), arm)
