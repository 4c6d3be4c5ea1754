"""Stage `maps`: the map of every visit, from its detections."""

from ovman.perception import maps
from ovman.workflow.job import job

with job(snakemake) as work:
    maps.run(work.inputs("detections"), work.constants, work.outputs("maps"))
