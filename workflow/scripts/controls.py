"""Stage `controls`: of all splits, who reaches what, controls beside the agents, arm against arm, and success by coverage."""

from ovman.analysis import controls, coverage, overview, split_significance
from ovman.workflow.job import job

with job(snakemake) as work:
    judged = work.inputs("rates"), work.inputs("outcomes"), work.constants
    controls.run(*judged, work.output("controls"))
    coverage.run(*judged, work.output("coverage"))
    overview.run(*judged, work.output("overview"))
    split_significance.run(*judged, work.output("split_significance"))
