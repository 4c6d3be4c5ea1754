"""Stage `segments`: what the frames of an episode's tours show, and what both tours say of its place."""

from ovman.evaluation import segments
from ovman.evaluation.observations import VISITS
from ovman.workflow.job import job

with job(snakemake) as work:
    detections, output = work.input("detections"), work.output("segments")
    episodes = work.inputs("episodes")
    segments.write_segments(work.constants, episodes, detections.parent, VISITS, output.parent, detections.stem)
