"""The tours that an agent needs, recorded once from the records of the episodes and kept in a folder of the user's."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

from ovman.evaluation.tours import record_tour, tour_key
from ovman.records.episode import Episode
from ovman.records.visit_files import kept
from ovman.sim.session import Session
from ovman.workflow.journal import digest
from ovman.workflow.locks import held
from ovman.workflow.provenance import module_digest

VISITS = ("first", "second")
MIN_MASK_PX = 1
"""Smaller masks are not written down; no agent reads them."""
CODE = ("ovman.evaluation.tours", "ovman_engine.__main__")
"""What records a tour, and the engine that it is recorded in; a recording of other code is made again."""


def recording_key(episode: Episode, which: str) -> str:
    """Digest of all that the recording of a visit "first" or "second" of an episode follows from.

    What the episode is asked is no part of it, so episodes with one visit in common have one recording. A visit in which
    something moves is the episode's own, since movers draw by its id.
    """
    alterations = [alteration.to_json() for alteration in episode.alterations(which)]
    moving = episode.id if any(alteration["kind"] == "motion" for alteration in alterations) else None
    protocol = episode.protocol.model_dump(mode="json", exclude={"success"})
    tour = episode.tours[which].model_dump(mode="json")
    made_in = [episode.backend, episode.scene, episode.visits[which], episode.provenance.seed]
    return digest(*made_in, protocol, tour, alterations, moving, _code())


class TourCache:
    """Recorded tours below `directory`, a folder for each scene and key. Processes may share it.

    say: told of each tour that is recorded, before.
    """

    def __init__(self, directory: Path, say: Callable[[str], None]) -> None:
        self.directory, self._tours, self._say = directory, directory / "tours", say

    def places(self, session: Session, episode: Episode) -> Mapping[str, Path]:
        """The directories of the tours of an episode by the names of its visits; those that are missing or damaged are recorded.

        session: on the episode's scene with the benchmark's body. SimulatorError if the simulator refuses.
        """
        return {episode.visits[which]: self._recorded(session, episode, which) for which in VISITS}

    def _recorded(self, session: Session, episode: Episode, which: str) -> Path:
        key = recording_key(episode, which)
        above = self._tours / episode.scene / key
        place = above / episode.visits[which]
        with held(above.with_name(f".{key}.lock")):
            if not kept(place, tour_key(episode, which, MIN_MASK_PX, key)):
                self._say(f"recording the {which} tour of {episode.id}")
                session.with_restarts(partial(record_tour, session, episode, which, above, MIN_MASK_PX, key))
        return place


@cache
def _code() -> tuple[str | None, ...]:
    return tuple(module_digest(module) for module in CODE)
