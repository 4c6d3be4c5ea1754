"""Stage `tables`: every table of the results as .csv, .md and .tex."""

from ovman.report.tables import write_paper_tables
from ovman.workflow.job import job

with job(snakemake) as work:
    write_paper_tables(work.inputs("metrics"), work.constants, work.output("tables"), work.inputs("notes"))
