"""What turns a visit into the clusters of its map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from ovman.agents.agent import Visit
from ovman.perception.clusters import Cluster


class Mapper(Protocol):
    """The eyes of the reference agent."""

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of a visit's map."""


class KeptMaps:
    """Maps that were made of known tours, found again by what the tours show. No frame is looked at.

    maps: clusters by the content of the tour (``Visit.content``).
    """

    def __init__(self, maps: Mapping[str, Sequence[Cluster]]) -> None:
        self._maps = dict(maps)

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of the visit's map. ValueError for a tour of which no map was made."""
        if visit.content is None or visit.content not in self._maps:
            raise ValueError(f"no map was made of the tour with the content {visit.content}; make the stage maps again")
        return self._maps[visit.content]
