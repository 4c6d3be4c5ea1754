"""Stage `perception`: what was detected in the recorded tours, against the true instances of their pictures."""

from pathlib import Path

from ovman.analysis import perception
from ovman.workflow.job import job

VISITS = Path("results", "visits")

with job(snakemake) as work:
    perception.write_perception(
        work.inputs("scenes"),
        work.inputs("detections"),
        work.inputs("episodes"),
        work.input("nouns"),
        VISITS,
        work.constants,
        work.output("perception"),
    )
