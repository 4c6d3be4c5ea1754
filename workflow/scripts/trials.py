"""Stage `trials`: every candidate of a scene is brought about and measured."""

from pathlib import Path
from typing import Any

from ovman.generation import trials
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    trials.run(
        work.input("candidates"),
        work.input("scene"),
        work.constants,
        work.output("trials"),
        Path("results/visits", work.scene),
        work.journal(),
    )
