"""Stage `static_tables`: the tables of the static gate alone."""

from ovman.report.tables import write_static_tables
from ovman.workflow.job import job

with job(snakemake) as work:
    write_static_tables(work.input("episodes"), work.inputs("predictions"), work.constants, work.output("tables"))
