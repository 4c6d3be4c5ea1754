"""The rules of perceive.smk: what networks see in recorded tours, and the maps that agents build of it.

Each function is called like its rule and imports what it calls: a job starts sooner without the modules of other rules.
"""

from collections.abc import Sequence
from pathlib import Path

from stage import Job, run

VISITS = Path("results", "visits")


def tours_of(episodes: Sequence[Path], manifests: Path) -> dict[str, dict[str, Path]]:
    """Return the folders of the tours of episodes, by scene and visit, sorted."""
    from ovman.records.episode import Episode
    from ovman.records.visit import VisitManifest

    names: dict[str, set[str]] = {}
    for file in episodes:
        for episode in Episode.load(file):
            names.setdefault(episode.scene, set()).update((episode.visits.first, episode.visits.second))
    return {
        manifest.scene: {name: manifest.tour(VISITS, name) for name in sorted(names.get(manifest.scene, ()))}
        for manifest in VisitManifest.read(manifests)
    }


def nouns(job: Job) -> None:
    from ovman.language.vocabulary import all_nouns
    from ovman.perception import networks

    networks.write_noun_embeddings(all_nouns(), job.settings, Path(job.output.nouns))


def detections(job: Job) -> None:
    from ovman.perception import detections as sight

    tours = tours_of(job.files("episodes"), Path(job.input.visits))
    sight.run(tours, job.settings, job.cache(), Path(job.output.detections), job.workers)


def maps(job: Job) -> None:
    from ovman.perception import maps as mapping

    mapping.run(Path(job.input.detections), job.settings, Path(job.output.maps))


def maintained(job: Job) -> None:
    from ovman.perception import maps as mapping

    files = Path(job.input.episodes), Path(job.input.detections)
    mapping.run_both_visits(*files, job.settings, Path(job.output.maintained))


def segments(job: Job) -> None:
    from ovman.evaluation import segments as weighing

    folders = Path(job.input.detections), VISITS, Path(job.output.segments)
    weighing.run(job.settings, job.files("episodes"), *folders, job.workers)


def labels(job: Job) -> None:
    from ovman.perception import labels as truth

    truth.run(job.files("scenes"), Path(job.input.detections), VISITS, Path(job.output.labels), job.workers)


def walks(job: Job) -> None:
    from ovman.agents.dualmap import walks as dense_tours

    files = job.files("scenes"), job.file("episodes"), VISITS
    outputs = Path(job.output.walks), Path(job.output.labels)
    dense_tours.run(*files, job.settings, job.cache(), *outputs, job.workers)


def dualmap(job: Job) -> None:
    from ovman.agents.dualmap import maps as dualmap_maps

    dualmap_maps.run(job.file("episodes"), Path(job.input.walks), job.settings, Path(job.output.dualmap), job.workers)


def readmitted_maps(job: Job) -> None:
    from ovman.perception import maps as mapping

    tours = tours_of(job.files("episodes"), Path(job.input.visits))
    mapping.run_tours(tours, job.settings, job.cache("detections", job.params.sight), Path(job.output.maps), job.workers)


run(snakemake, globals())  # noqa: F821 (Snakemake defines it)
