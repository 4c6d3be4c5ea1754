"""Stage `static`: the tables of the static gate alone."""

from ovman.job import job
from ovman.report import static

with job(snakemake) as work:
    static.run(work.input("episodes"), work.inputs("predictions"), work.constants, work.output("static"))
