"""Stage `pictures`: views of a floor plan that the benchmark does not use."""

from training import recording
from ovman.workflow.job import job

with job(snakemake) as work:
    recording.run(work.scene, work.constants, work.output("pictures"))
