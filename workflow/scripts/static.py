"""Stage `static`: the tables of the static gate alone."""

from ovman.report import static
from ovman.workflow.job import job

with job(snakemake) as work:
    static.run(work.input("episodes"), work.inputs("predictions"), work.constants, work.output("static"))
