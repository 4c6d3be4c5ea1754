"""Stage `figures`: the picture of the six relations."""

from pathlib import Path

from ovman.report import relations
from ovman.workflow.job import job

with job(snakemake) as work:
    relations.run(work.input("episodes"), Path("results", "visits"), work.constants, work.output("relations"))
