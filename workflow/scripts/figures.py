"""Stage `figures`: the picture of the six relations."""

from pathlib import Path

from ovman.report.figures.relations import draw_relations
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    draw_relations(work.inputs("episodes"), Path("results", "visits"), work.constants, directory / "relations.png")
