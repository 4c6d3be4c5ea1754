"""Stage `simulator`: one frame of the Unity build, before any scene needs it."""

from ovman.doctor import simulator
from ovman.workflow.job import job

with job(snakemake) as work:
    simulator.run(work.output("simulator"))
