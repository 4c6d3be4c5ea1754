"""Stage `walks`: what DualMap observes on the dense walks of a scene's visits."""

from pathlib import Path

from ovman.agents.dualmap import walks
from ovman.workflow.job import job

with job(snakemake) as work:
    visits = Path("results/visits", work.scene)
    walks.run(
        work.scene,
        walks.assigned(work.scene, work.input("episodes"), work.input("trials"), visits),
        work.constants,
        work.journal().with_suffix(""),
        work.output("walks"),
    )
