"""Stage `controls`: on each split, controls beside the agents by relation, arm against arm, and success by coverage."""

from ovman.analysis import controls, coverage, split_significance
from ovman.workflow.job import job

with job(snakemake) as work:
    judged = work.inputs("rates"), work.inputs("outcomes"), work.constants
    controls.run(*judged, work.output("controls"))
    coverage.run(*judged, work.output("coverage"))
    split_significance.run(*judged, work.output("split_significance"))
