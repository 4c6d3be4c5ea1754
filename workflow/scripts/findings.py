"""Stage `findings`: the results beside the paper's, as a page with two charts."""

from ovman.report.paper_comparison import page
from ovman.workflow.job import job

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
