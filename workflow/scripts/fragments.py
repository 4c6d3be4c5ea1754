"""Stage `fragments`: into how many objects of a map each target falls, and whether the agent grounds it."""

from pathlib import Path

from ovman.analysis import maps
from ovman.workflow.job import job

with job(snakemake) as work:
    maps.write_fragments(
        work.input("episodes"),
        work.input("predictions"),
        work.inputs("scenes"),
        work.inputs("detections"),
        work.inputs("maps"),
        Path("results", "visits"),
        work.constants,
        work.output("fragments"),
    )
