"""Stage `metrics`: one row an (episode, arm, seed), and rates."""

from typing import Any

from ovman.analysis import metrics
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    with work.gathered() as directory:
        metrics.run(work.input("episodes"), work.inputs("predictions"), work.inputs("runs"), work.constants, directory)
