"""Stage `rollouts`: an embodied arm runs the episodes of one scene or several, once for each seed."""

import tempfile
from pathlib import Path

from ovman.cache import Cache, digest
from ovman.evaluation import rollouts
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.workflow.job import job

with job(snakemake) as work, tempfile.TemporaryDirectory() as folder:
    outputs: dict[str, dict[int, Path]] = {}
    for name, places in snakemake.output.items():
        for place, file in zip(places, work.outputs(name), strict=True):
            outputs.setdefault(Path(place).stem, {})[int(name.removeprefix("seed"))] = file
    episodes, every = Path(folder, "episodes.jsonl"), Path(folder, "rollouts.jsonl")
    episodes.write_text(lines([one for scene in outputs for one in Episode.load(work.input("episodes"), scene)]))
    names = ("maps", "dualmap", "detections", "segments")
    perceived = {name: files[0].parent for name in names if (files := work.inputs(name))}
    rollouts.run(
        work.constants.arm,
        work.constants,
        episodes,
        sorted({seed for of_seeds in outputs.values() for seed in of_seeds}),
        every,
        Cache(Path("results", "cache", "rollouts", digest(work.constants.canonical))),
        perceived | ({"nouns": work.input("nouns")} if work.inputs("nouns") else {}),
        next(iter(work.inputs("sightings")), None),
        next(iter(work.inputs("predictions")), None),
    )
    done = Rollout.read(every)
    for scene, of_seeds in outputs.items():
        for seed, output in of_seeds.items():
            output.parent.mkdir(parents=True, exist_ok=True)
            output.write_text(lines(run for run in done if run.seed == seed and run.episode.startswith(f"{scene}/")))
