"""Stage `findings`: the results beside the paper's, as a page with two charts."""

from ovman.job import job
from ovman.report.findings import page

with job(snakemake) as work:
    page.run(
        work.inputs("metrics"),
        work.input("paper"),
        work.input("explanations"),
        work.input("template"),
        work.constants,
        page=work.output("page"),
        budget_chart=work.output("budget"),
        memory_chart=work.output("memory"),
    )
