"""Stage `cues`: cues of appearance of what was detected in every tour, and what it truly shows."""

from pathlib import Path

from ovman.analysis import cues
from ovman.workflow.job import job

VISITS = Path("results", "visits")

with job(snakemake) as work, work.gathered() as directory:
    cues.write_cues(work.inputs("scenes"), work.inputs("detections"), VISITS, work.constants, directory)
