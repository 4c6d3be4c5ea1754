"""The rules of this package: CoW and DualMap as their authors released them."""

import json
import sys
from pathlib import Path

from ovman.agents.dualmap import maps, walks
from ovman.evaluation import predictions
from ovman.language.vocabulary import all_nouns
from ovman.records.episode import Episode
from ovman.records.note import Note

sys.path.append(snakemake.params.scripts)  # noqa: F821 (Snakemake defines it)
from stage import Job, run

# The package may lie next to an overlay, where only a job looks for modules.
from ovman_released import cow, dualmap, dualmap_setup
from ovman_released.settings import released_dualmap as section

VISITS = Path("results", "visits")


def released_cow(job: Job) -> None:
    outputs = Path(job.output.rollouts), Path(job.output.note)
    cow.run(job.file("episodes"), job.settings, job.params.seeds, *outputs, job.cache())


def released_dualmap_setup(job: Job) -> None:
    missing = dualmap_setup.lacks(section(job.settings))
    if missing is not None:
        print(f"{dualmap_setup.SYSTEM} is not run: {missing}", flush=True)
    Note(system=dualmap_setup.SYSTEM, missing=missing or "").write(Path(job.output.note))


def released_dualmap(job: Job) -> None:
    folder, nouns = Path(job.output.maps), Path(job.output.nouns)
    folder.mkdir(parents=True, exist_ok=True)
    if not Note.load(job.file("note")).ran:
        nouns.touch()
        return
    floors = {row["scene"]: row["floor_y"] for row in map(json.loads, job.file("scenes").read_text().splitlines())}
    for scene in dict.fromkeys(episode.scene for episode in Episode.load(job.file("episodes"))):
        episodes = Episode.load(job.file("episodes"), scene)
        dualmap.run(
            scene,
            walks.assign_visits(episodes, VISITS / scene),
            maps.find_pairs(episodes),
            floors[scene],
            sorted(set(all_nouns())),
            job.settings,
            job.cache().directory / scene,
            folder / f"{scene}.npz",
            nouns,
        )


def released_dualmap_predictions(job: Job) -> None:
    output = Path(job.output.predictions)
    if not Note.load(job.file("note")).ran:
        output.touch()
        return
    perceived = {"dualmap": job.file("dualmap"), "nouns": job.file("nouns")}
    predictions.run(job.arm, job.settings, job.file("episodes"), output, perceived, job.file("sightings"))


run(snakemake, globals())  # noqa: F821 (Snakemake defines it)
