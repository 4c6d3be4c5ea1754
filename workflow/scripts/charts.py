"""Stage `charts`: the figures that metrics alone are needed for, and the drawing of the agent."""

from ovman.report.figures import charts
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    charts.run(work.inputs("metrics"), work.input("paper"), work.constants, directory)
