"""Stage `figures`: the picture of the six relations."""

from pathlib import Path

from ovman.job import job
from ovman.report import relations

with job(snakemake) as work:
    relations.run(work.input("episodes"), Path("results", "visits"), work.constants, work.output("relations"))
