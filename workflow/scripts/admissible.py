"""Stage `admissible`: the verdict on every trial of a scene."""

from ovman.generation import admissible
from ovman.workflow.job import job

with job(snakemake) as work:
    admissible.run(work.input("trials"), work.constants, work.output("admissible"))
