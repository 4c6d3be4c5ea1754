"""Stage `walks`: what DualMap observes on the dense walks of a scene's visits."""

from pathlib import Path

from ovman.agents.dualmap import walks
from ovman.records.episode import Episode
from ovman.workflow.job import job

with job(snakemake) as work:
    episodes = Episode.load(work.input("episodes"), work.scene)
    walks.run(
        work.input("scene"),
        walks.assigned(episodes, Path("results", "visits", work.scene)),
        work.constants,
        work.journal().with_suffix(""),
        work.output("walks"),
        work.output("labels"),
    )
