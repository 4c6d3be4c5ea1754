"""Stage `dualmap`: DualMap's maps of the visits of a scene, and of its pairs of visits, in every run."""

from ovman.agents.dualmap import maps
from ovman.workflow.job import job

with job(snakemake) as work:
    maps.run(
        work.scene,
        work.input("walks"),
        work.input("episodes"),
        work.constants,
        work.output("dualmap"),
    )
