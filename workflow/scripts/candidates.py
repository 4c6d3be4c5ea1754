"""Stage `candidates`: changes that might make an episode, drawn for a scene."""

from typing import Any

from ovman.generation import candidates
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    candidates.run(work.input("scene"), work.constants, work.output("candidates"))
