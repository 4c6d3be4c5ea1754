"""Stage `dualmap_objects`: how many objects DualMap's maps hold."""

from ovman.analysis import maps
from ovman.workflow.job import job

with job(snakemake) as work:
    maps.write_dualmap(work.inputs("dualmap"), work.output("objects"))
