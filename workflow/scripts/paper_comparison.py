"""Stage `paper_comparison`: the results beside the paper's, as a page with two charts."""

from ovman.report.paper_comparison import page
from ovman.workflow.job import job

with job(snakemake) as work:
    page.run(
        work.inputs("metrics"),
        page.Sources(*(work.input(name) for name in ("paper", "statements", "explanations", "template"))),
        work.constants,
        page=work.output("page"),
        budget_chart=work.output("budget"),
        memory_chart=work.output("memory"),
    )
