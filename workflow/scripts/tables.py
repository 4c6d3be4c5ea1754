"""Stage `tables`: every table of the results as .csv, .md and .tex."""

from ovman.report import tables
from ovman.workflow.job import job

with job(snakemake) as work:
    tables.run(work.inputs("metrics"), work.constants, work.output("tables"), work.inputs("notes"))
