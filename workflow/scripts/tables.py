"""Stage `tables`: every table of the results as .csv, .md and .tex."""

from ovman.report.tables import stages
from ovman.workflow.job import job

with job(snakemake) as work:
    stages.run(work.inputs("metrics"), work.constants, work.output("tables"), work.inputs("notes"), work.input("position"))
