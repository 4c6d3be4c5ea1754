"""Stage `readmitted`: the trials that some setting of the thresholds admits, as episodes, and which settings admit each."""

from ovman.generation import readmission
from ovman.workflow.job import job

with job(snakemake) as work:
    readmission.run(
        work.inputs("trials"),
        work.input("released"),
        work.constants,
        work.output("episodes"),
        work.output("admissions"),
    )
