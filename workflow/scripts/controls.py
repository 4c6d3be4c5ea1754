"""Stage `controls`: controls and the agents that they are set beside by relation, for each split."""

from ovman.analysis import controls
from ovman.workflow.job import job

with job(snakemake) as work:
    controls.run(work.inputs("rates"), work.inputs("outcomes"), work.constants, work.output("controls"))
