"""Stage `charts`: the figures that show metrics, and the drawing of the agent."""

from ovman.report.figures import draw_charts
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    draw_charts(work.inputs("metrics"), work.constants, directory)
