"""Stage `sensitivity`: the margin of memory under every setting of the thresholds."""

from ovman.analysis import probes
from ovman.workflow.job import job

with job(snakemake) as work:
    probes.write_sensitivity(
        work.input("admissions"),
        work.input("episodes"),
        work.input("arm"),
        work.input("baseline"),
        work.constants,
        work.output("sensitivity"),
    )
