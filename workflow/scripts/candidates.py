"""Stage `candidates`: changes that might make an episode, drawn for a scene."""

from ovman.generation import candidates
from ovman.workflow.job import job

with job(snakemake) as work:
    candidates.run(work.input("scene"), work.constants, work.output("candidates"))
