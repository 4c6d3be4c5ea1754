"""Stage `segments`: what the frames of an episode's tours show, and what both tours say of its place."""

from ovman.evaluation import segments
from ovman.evaluation.predictions import VISITS
from ovman.workflow.job import job

with job(snakemake) as work:
    segments.run(work.input("detections"), work.inputs("episodes"), VISITS, work.constants, work.output("segments"))
