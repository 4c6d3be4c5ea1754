"""Stage `controls`: on each split, controls and the agents that they are set beside by relation, and arm against arm."""

from ovman.analysis import controls, split_significance
from ovman.workflow.job import job

with job(snakemake) as work:
    judged = work.inputs("rates"), work.inputs("outcomes"), work.constants
    controls.run(*judged, work.output("controls"))
    split_significance.run(*judged, work.output("split_significance"))
