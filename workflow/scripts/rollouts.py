"""Stage `rollouts`: an embodied arm runs the episodes of a scene, once for each seed."""

from ovman.evaluation import rollouts
from ovman.workflow.job import job

with job(snakemake) as work:
    rollouts.run(
        work.constants.arm,
        work.scene,
        work.input("episodes"),
        work.constants,
        {int(name.removeprefix("seed")): work.output(name) for name, _ in snakemake.output.items()},
        work.journal(),
        next(iter(work.inputs("sightings")), None),
        files={name: work.inputs(name) for name in ("maps", "dualmap", "detections", "segments", "nouns")},
        predictions=next(iter(work.inputs("predictions")), None),
    )
