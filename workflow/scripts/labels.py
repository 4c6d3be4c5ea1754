"""Stage `labels`: what the detections of every tour truly show."""

from pathlib import Path

from ovman.evaluation import labels
from ovman.workflow.job import job

with job(snakemake) as work:
    labels.run(work.inputs("scenes"), work.inputs("detections"), Path("results", "visits"), work.outputs("labels"))
