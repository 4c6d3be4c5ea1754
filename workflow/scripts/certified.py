"""Stage `certified`: the oracle agent runs the admissible trials of a scene."""

from ovman.generation import certified
from ovman.workflow.job import job

with job(snakemake) as work:
    certified.run(work.input("admissible"), work.input("trials"), work.constants, work.output("certified"), work.journal())
