"""Stage `certified`: the oracle agent runs the admissible trials of a scene."""

from ovman.generation import certification
from ovman.workflow.job import job

with job(snakemake) as work:
    certification.run(work.input("admissible"), work.input("trials"), work.constants, work.output("certified"), work.journal())
