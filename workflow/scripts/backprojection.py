"""Stage `backprojection`: how far from its object the place of a mask is."""

from pathlib import Path

from ovman.analysis import backprojection
from ovman.workflow.job import job

VISITS = Path("results", "visits")

with job(snakemake) as work:
    backprojection.write_backprojection(work.inputs("scenes"), work.inputs("detections"), VISITS, work.constants, work.output("backprojection"))
