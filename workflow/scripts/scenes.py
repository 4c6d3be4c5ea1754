"""Stage `scenes`: what is in a scene before anything changes."""

from ovman.generation import scenes
from ovman.workflow.job import job

with job(snakemake) as work:
    scenes.run(work.scene, work.constants, work.output("scene"), work.journal())
