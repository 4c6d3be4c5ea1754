"""Stage `paper_comparison`: the page that sets the results next to the paper's."""

from ovman.report.results_page import write_page
from ovman.workflow.job import job

with job(snakemake) as work:
    write_page(work.inputs("metrics"), work.constants, work.output("page"))
