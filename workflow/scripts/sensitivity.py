"""Stage `sensitivity`: the margin of memory under every setting of the thresholds."""

from ovman.analysis import sensitivity
from ovman.workflow.job import job

with job(snakemake) as work:
    sensitivity.run(
        work.input("admissions"),
        work.input("episodes"),
        work.input("arm"),
        work.input("baseline"),
        work.constants,
        work.output("sensitivity"),
    )
