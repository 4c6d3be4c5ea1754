"""The tours of an episode, recorded again from its record alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

from ovman import seeds
from ovman.agents.interface import VISITS
from ovman.atomic import hold_lock
from ovman.cache import digest
from ovman.provenance import ENGINE, digest_code
from ovman.records.episode import Episode
from ovman.records.visit import Visit, kept, tour_path
from ovman.sim import visit
from ovman.sim.session import Session
from ovman.sim.world import World, is_dynamic


def record_tour(session: Session, episode: Episode, which: str, directory: Path, min_mask_px: int = 1) -> Visit:
    """Tour the home in a visit of an episode and record the frames in a folder of `directory` that is named after the visit.

    Movers draw as they did when the episode was made, so the tour ends in the state in which a run begins. The session has the
    benchmark's body. Masks of fewer pixels than min_mask_px are not recorded; no agent reads those of `TourCache`.
    """
    alterations, name, tour = episode.alterations(which), episode.visits[which], episode.tours[which]
    rng = seeds.generator(episode.provenance.seed, *seeds.tour_movers(episode.id))
    world = World(session, alterations, episode.protocol.mover, rng, is_dynamic)
    views, file, key = visit.views(tour), tour_path(directory, name), recording_key(episode, which)
    return visit.record(session, world, name, alterations, views, min_mask_px, file, key, tour.light, tour.sensors)


def recording_key(episode: Episode, which: str) -> str:
    """Return a digest of everything that the recording of a visit of an episode depends on, code included.

    The question is not part of it, so episodes with one visit in common have one recording. A visit in which something moves is
    the episode's own, since movers draw by its id.
    """
    alterations = [alteration.to_json() for alteration in episode.alterations(which)]
    moving = episode.id if any(alteration["kind"] == "motion" for alteration in alterations) else None
    protocol = episode.protocol.model_dump(mode="json", exclude={"success"})
    tour = episode.tours[which].model_dump(mode="json")
    world = [episode.backend, episode.scene, episode.visits[which], episode.provenance.seed]
    return digest(*world, protocol, tour, alterations, moving, _digest_own_code())


class TourCache:
    """Recorded tours below `directory`, one folder per scene and key. Processes may share it."""

    def __init__(self, directory: Path, say: Callable[[str], None]) -> None:
        """Open the cache. say: Told of each tour before it is recorded."""
        self.directory, self._tours, self._say = directory, directory / "tours", say

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


@cache
def _digest_own_code() -> str:
    return digest_code(__name__, ENGINE)
