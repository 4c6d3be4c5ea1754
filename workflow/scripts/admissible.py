"""Stage `admissible`: the verdict on every trial of a scene."""

from ovman.generation import verdict
from ovman.workflow.job import job

with job(snakemake) as work:
    verdict.run(work.input("trials"), work.constants, work.output("admissible"))
