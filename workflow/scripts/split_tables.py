"""Stage `split_tables`: the tables of one split as .csv, .md and .tex."""

from ovman.report.tables import write_tables
from ovman.workflow.job import job

with job(snakemake) as work:
    write_tables(work.inputs("metrics"), work.constants, work.output("tables"))
