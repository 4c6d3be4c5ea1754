"""Stage `dualmap_objects`: how many objects DualMap's maps hold."""

from ovman.analysis import dualmap_objects
from ovman.workflow.job import job

with job(snakemake) as work:
    dualmap_objects.run(work.inputs("dualmap"), work.output("objects"))
