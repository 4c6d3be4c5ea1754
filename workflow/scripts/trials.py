"""Stage `trials`: every candidate of a scene is brought about and measured."""

from pathlib import Path

from ovman.generation import trials
from ovman.workflow.job import job

with job(snakemake) as work:
    trials.run(
        work.input("candidates"),
        work.input("scene"),
        work.constants,
        work.output("trials"),
        work.output("visits"),
        Path("results/visits", work.scene),
        work.journal(),
    )
