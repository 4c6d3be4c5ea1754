"""Stage `labels`: what the detections of every tour truly show."""

from pathlib import Path

from ovman.evaluation import labels
from ovman.workflow.job import job

with job(snakemake) as work:
    for scene, detections, output in zip(work.inputs("scenes"), work.inputs("detections"), work.outputs("labels"), strict=True):
        labels.label_scene(detections.parent, Path("results", "visits"), output.parent, scene.read_text())
