"""Stage `figures`: the picture of the six relations."""

from pathlib import Path

from ovman.report.figures import relations
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    relations.run(work.inputs("episodes"), Path("results", "visits"), work.constants, directory / "relations.png")
