"""Stage `maps`: the map of every visit, from its detections."""

from ovman.job import job
from ovman.perception import maps

with job(snakemake) as work:
    maps.run(work.inputs("detections"), work.constants, work.outputs("maps"))
