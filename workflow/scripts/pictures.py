"""Stage `pictures`: views of a floor plan that the benchmark does not use."""

from ovman.workflow.job import job
from training import pictures
from training.floorplans import floor_plans

with job(snakemake) as work:
    is_held_out = work.scene in floor_plans(work.constants.splits["main"].scenes).held_out
    pictures.run(work.scene, is_held_out, work.constants, work.output("pictures"))
