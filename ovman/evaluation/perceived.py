"""What perception made of a scene before any agent is asked: maps of its visits, and nouns as vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.perception.clusters import Cluster
from ovman.perception.object_map import ObjectMap
from ovman.perception.records import read_maps, read_nouns


@dataclass(frozen=True, slots=True, eq=False)
class Perceived:
    """maps: the clusters of every visit by the visit's name; nouns: noun phrases as unit vectors (K,)."""

    maps: Mapping[str, Sequence[Cluster]]
    nouns: Mapping[str, np.ndarray]

    def map(self, visit: str) -> ObjectMap:
        """The map of a visit. ValueError for a visit without a map."""
        if visit not in self.maps:
            raise ValueError(f"the visit {visit!r} has no map; make the stage maps again")
        return ObjectMap.of(self.maps[visit])

    def noun(self, phrase: str) -> np.ndarray:
        """The embedding (K,) of a noun phrase. ValueError for one without an embedding."""
        if phrase not in self.nouns:
            raise ValueError(f"the noun {phrase!r} has no embedding; make the stage nouns again")
        return self.nouns[phrase]


def read_perceived(maps_files: Sequence[Path], nouns_file: Path | None) -> dict[str, Perceived]:
    """What was perceived, by scene; nothing without a file of nouns."""
    if nouns_file is None:
        return {}
    nouns = read_nouns(nouns_file)
    return {file.stem: Perceived(read_maps(file), nouns) for file in maps_files}
