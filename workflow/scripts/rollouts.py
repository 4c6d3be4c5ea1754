"""Stage `rollouts`: an embodied arm runs the episodes of one scene or several, once for each seed."""

from pathlib import Path

from ovman.evaluation import rollouts
from ovman.workflow.job import job

with job(snakemake) as work:
    outputs: dict[str, dict[int, Path]] = {}
    for name, places in snakemake.output.items():
        for place, file in zip(places, work.outputs(name), strict=True):
            outputs.setdefault(Path(place).stem, {})[int(name.removeprefix("seed"))] = file
    rollouts.run(
        work.constants.arm,
        work.input("episodes"),
        work.constants,
        outputs,
        {scene: work.journal(scene) for scene in outputs},
        next(iter(work.inputs("sightings")), None),
        files={name: work.inputs(name) for name in ("maps", "dualmap", "detections", "segments", "nouns")},
        predictions=next(iter(work.inputs("predictions")), None),
    )
