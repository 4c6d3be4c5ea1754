"""The scripted change of an episode (delta)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ovman.task.pose import Position, point_to_json, read_points
from ovman.task.record import Node
from ovman.task.world_state import Point

CHANGE_KINDS = ("displace", "enable", "disable", "motion")


@dataclass(frozen=True, slots=True)
class Change:
    """One scripted change of one instance.

    before, after: where the instance was in visit 1 and was put for visit 2, None where it is absent; path: floor-plane
    positions of a mover, agent step by agent step, None for others.
    """

    instance: str
    kind: str
    before: Position | None
    after: Position | None
    path: tuple[Point, ...] | None = None

    @staticmethod
    def read(node: Node) -> Change:
        return Change(
            instance=node["instance"].text(),
            kind=node["kind"].one_of(CHANGE_KINDS),
            before=node["before"].optional(Position.read),
            after=node["after"].optional(Position.read),
            path=node["path"].optional(read_points),
        )

    def to_json(self) -> dict[str, Any]:
        return {
            "instance": self.instance,
            "kind": self.kind,
            "before": None if self.before is None else self.before.to_json(),
            "after": None if self.after is None else self.after.to_json(),
            "path": None if self.path is None else [point_to_json(point) for point in self.path],
        }
