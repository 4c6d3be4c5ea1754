"""Stage `split_tables`: the tables of one split as .csv, .md and .tex."""

from ovman.report.tables import stages
from ovman.workflow.job import job

with job(snakemake) as work:
    stages.run_split(work.inputs("metrics"), work.constants, work.output("tables"))
