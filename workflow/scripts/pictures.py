"""Stage `pictures`: views of a floor plan that the benchmark does not use."""

from ovman.job import job
from ovman.training import record

with job(snakemake) as work:
    record.run(work.scene, work.constants, work.output("pictures"))
