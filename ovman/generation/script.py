"""What a candidate's alterations mean for its query before any simulator has seen them. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ovman.records.change import Alteration
from ovman.records.geometry import Point
from ovman.records.query import Query
from ovman.records.relation import Relation
from ovman.records.scene import Scene
from ovman.records.world_state import Instance, WorldState
from ovman.task import answer, crowding

Kind = Literal["displace", "enable", "disable", "motion"]
"""As `Change.kind`: "enable" is gone in the first visit alone."""
KIND_OF: Mapping[Relation, Kind] = {
    Relation.MOVED: "displace",
    Relation.FORMER: "displace",
    Relation.STABLE: "displace",
    Relation.MOVING: "motion",
    Relation.APPEARED: "enable",
    Relation.REMOVED: "disable",
}
"""The kind of the scripted change of each relation."""
SHOWN_IN: Mapping[Kind, Literal["first", "second"]] = {
    "displace": "first",
    "motion": "second",
    "enable": "second",
    "disable": "first",
}
"""The tour in which a change shows its instance: the one from which it takes it, or to which it brings it."""


@dataclass(frozen=True)
class Script:
    """A query about a target of an untouched scene, and what scripted alterations of the scene mean for it."""

    scene: Scene
    query: Query
    target: str

    def answer(self, first: Sequence[Alteration], second: Sequence[Alteration]) -> Point:
        """Where the query is answered (Eq. 3) if everything comes to lie where it is put, metres."""
        return answer(self._world(first), self._world(second), self.query, self.target)

    def crowded(self, first: Sequence[Alteration], second: Sequence[Alteration], radius_m: float) -> bool:
        """Whether another instance of the category would be at most `radius_m` from the answer."""
        at = self.answer(first, second)
        return bool(crowding(self._world(first), self._world(second), self.query, self.target, at, radius_m))

    def _world(self, alterations: Sequence[Alteration]) -> WorldState:
        gone = {alteration.instance for alteration in alterations if alteration.kind == "disable"}
        placed = {alteration.instance: alteration.placement for alteration in alterations if alteration.placement is not None}
        return WorldState(
            tuple(
                Instance(o.id, o.category, *placed.get(o.id, (o.position.x, o.position.z)))
                for o in self.scene.objects
                if o.category == self.query.category and o.id not in gone
            )
        )
