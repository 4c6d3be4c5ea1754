"""Stage `paper_comparison`: the results beside the paper's, as a page."""

from ovman.report.paper_comparison import page
from ovman.workflow.job import job

with job(snakemake) as work:
    page.run(
        work.inputs("metrics"),
        page.Sources(*(work.input(name) for name in ("paper", "statements", "own", "explanations", "template", "position"))),
        work.constants,
        page=work.output("page"),
    )
