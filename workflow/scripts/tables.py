"""Stage `tables`: every table of the results as .csv, .md and .tex."""

from ovman.job import job
from ovman.report import tables

with job(snakemake) as work:
    tables.run(work.inputs("metrics"), work.constants, work.output("tables"), work.inputs("released"))
