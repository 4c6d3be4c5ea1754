"""Stage `tours`: the tours of episodes, recorded from the episodes' records alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

from ovman import seeds
from ovman.agents.interface import VISITS
from ovman.atomic import hold_lock
from ovman.cache import digest
from ovman.processes import Units, map_items
from ovman.provenance import ENGINE, digest_code
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.visit import Visit, VisitFiles, VisitManifest, kept, tour_path
from ovman.settings import Settings
from ovman.sim import visit
from ovman.sim.session import Session
from ovman.sim.world import World, is_dynamic


def record_tour(session: Session, episode: Episode, which: str, directory: Path, min_mask_px: int = 1) -> Visit:
    """Tour the home in a visit of an episode and record the frames in a folder of `directory` that is named after the visit.

    Movers draw as they did when the episode was made, so the tour ends in the state in which a run begins. The session has the
    benchmark's body. Masks of fewer pixels than min_mask_px are not recorded; no agent reads those of `TourCache`.
    """
    alterations, name, tour = episode.alterations(which), episode.visits[which], episode.tours[which]
    rng = seeds.generator(episode.provenance.seed, *seeds.tour_movers(episode.streams))
    world = World(session, alterations, episode.protocol.mover, rng, is_dynamic)
    views, file, key = visit.views(tour), tour_path(directory, name), recording_key(episode, which, min_mask_px)
    return visit.record(session, world, name, alterations, views, min_mask_px, file, key, tour.light, tour.sensors)


def recording_key(episode: Episode, which: str, min_mask_px: int = 1) -> str:
    """Return a digest of everything that the recording of a visit of an episode depends on, code included.

    The question is not part of it, so episodes with one visit in common have one recording. A visit in which something moves
    belongs to an episode or a world pair, which names the movers' stream.
    """
    alterations = [alteration.to_json() for alteration in episode.alterations(which)]
    moving = episode.streams if any(alteration["kind"] == "motion" for alteration in alterations) else None
    protocol = episode.protocol.model_dump(mode="json", exclude={"success"})
    tour = episode.tours[which].model_dump(mode="json")
    world = [episode.backend, episode.scene, episode.visits[which], episode.provenance.seed]
    return digest(*world, protocol, tour, alterations, moving, min_mask_px, _digest_own_code())


TOURS = "tours"
"""Folder of a cache that has recorded tours."""


class TourCache:
    """Recorded tours below `directory`, one folder per scene and key. Processes may share it."""

    def __init__(self, directory: Path, say: Callable[[str], None]) -> None:
        """Open the cache. say: Told of each tour before it is recorded."""
        self.directory, self._tours, self._say = directory, directory / TOURS, say

    def places(self, session: Session, episode: Episode) -> Mapping[str, Path]:
        """Return the directories of the tours of an episode by the names of its visits; record those that are missing or damaged.

        session: On the episode's scene, with the benchmark's body. SimulatorError if the simulator refuses.
        """
        return {episode.visits[which]: self._record_if_missing(session, episode, which) for which in VISITS}

    def _record_if_missing(self, session: Session, episode: Episode, which: str) -> Path:
        key = recording_key(episode, which)
        above = self._tours / episode.scene / key
        place = tour_path(above, episode.visits[which])
        with hold_lock(above.with_name(f".{key}.lock")):
            if not kept(place, key):
                self._say(f"recording the {which} tour of {episode.id}")
                session.with_restarts(partial(record_tour, session, episode, which, above))
        return place


def run(episodes_file: Path, settings: Settings, manifest_out: Path, visits_dir: Path, workers: int = 1) -> None:
    """Record the tours of episodes and write their manifest, one row per scene.

    Tours lie in visits_dir/{scene}/{visit}.zip. Those that are whole and of the same code are kept.

    Args:
        episodes_file: The episodes.
        settings: measurement.min_mask_px.
        manifest_out: File of the manifest.
        visits_dir: Folder of the tours of all scenes.
        workers: Number of processes over the scenes.
    """
    by_scene: dict[str, list[Episode]] = {}
    for episode in Episode.load(episodes_file):
        by_scene.setdefault(episode.scene, []).append(episode)
    record = partial(_record_scene, visits_dir=visits_dir, min_mask_px=settings.measurement.min_mask_px)
    work = [lines(by_scene[scene]) for scene in sorted(by_scene)]
    manifest_out.write_text("".join(map_items(record, work, workers)), encoding="utf-8")


def _record_scene(episode_lines: str, visits_dir: Path, min_mask_px: int) -> str:
    """Return the manifest of the tours of episodes of one scene, as a line."""
    episodes = [Episode.parse(line) for line in episode_lines.splitlines()]
    tours = {episode.visits[which]: (episode, which) for episode in episodes for which in VISITS}
    scene, found, units = episodes[0].scene, dict[str, str](), Units(len(tours))
    with Session(scene, episodes[0].settings) as session:
        for name, (episode, which) in sorted(tours.items()):
            file = tour_path(visits_dir / scene, name)
            if not kept(file, recording_key(episode, which, min_mask_px)):
                session.with_restarts(partial(record_tour, session, episode, which, file.parent, min_mask_px))
            found[name] = VisitFiles.load(file).content
            units.done(name)
    return VisitManifest(scene=scene, visits=found).to_line()


@cache
def _digest_own_code() -> str:
    return digest_code(__name__, ENGINE)
