"""Stage `static_tables`: the tables of the static gate alone."""

from ovman.report.tables import stages
from ovman.workflow.job import job

with job(snakemake) as work:
    stages.run_static(work.input("episodes"), work.inputs("predictions"), work.constants, work.output("tables"))
