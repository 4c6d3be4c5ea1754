"""Changes of a home: what a candidate asks for (`Alteration`) and what an episode records of it (`Change`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

import numpy as np
from pydantic import SerializerFunctionWrapHandler, model_serializer, model_validator

from ovman.models.geometry import Point, Position
from ovman.models.record import Length, Record, Text


class Lane(Record):
    """A straight lane on the floor plane from (x_0, z_0) to (x_1, z_1), metres."""

    x_0: float
    z_0: float
    x_1: float
    z_1: float

    @property
    def length_m(self) -> float:
        """Length in metres."""
        return float(np.hypot(self.x_1 - self.x_0, self.z_1 - self.z_0))

    def at(self, along_m: float) -> Point:
        """The point `along_m` metres from the lane's beginning."""
        share = along_m / self.length_m
        return self.x_0 + share * (self.x_1 - self.x_0), self.z_0 + share * (self.z_1 - self.z_0)

    def along(self, x: float, z: float) -> float:
        """Metres from the lane's beginning to the point of the lane nearest to (x, z)."""
        dx, dz = self.x_1 - self.x_0, self.z_1 - self.z_0
        share = ((x - self.x_0) * dx + (z - self.z_0) * dz) / (dx * dx + dz * dz)
        return float(np.clip(share, 0.0, 1.0)) * self.length_m


_NEEDED: Mapping[str, tuple[str, ...]] = {"displace": ("placement", "height_m"), "motion": ("lane", "height_m")}
"""Fields without which the simulator cannot bring a change of that kind about."""


def _require(record: Record, instance: str, kind: str, names: tuple[str, ...]) -> None:
    for name in names:
        if getattr(record, name) is None:
            raise ValueError(f"{kind} of {instance} has no {name}")


class Alteration(Record):
    """One instance that is not as in the untouched scene.

    kind: "displace" (to `placement`, settling under gravity), "disable" (gone) or "motion" (put on `lane`, then moving).
    placement: where the centre of the instance's box is put, metres. height_m: the height from which the simulator looks down
    for a surface, at the placement or at the beginning of the lane. In files, keys without a value are left out.
    """

    kind: Literal["displace", "disable", "motion"]
    instance: Text
    placement: Point | None = None
    height_m: float | None = None
    lane: Lane | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        _require(self, self.instance, self.kind, _NEEDED.get(self.kind, ()))
        return self

    @model_serializer(mode="wrap")
    def _present(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {name: value for name, value in handler(self).items() if value is not None}


class MoverStart(Record):
    """Where a run finds the mover: at the end of the recorded tour of visit 2.

    along_m: metres from the beginning of its lane; direction: 1 away from the beginning, -1 back.
    """

    instance: Text
    along_m: Length
    direction: Literal[1, -1]


class MoverRecord(Record):
    """The mover of a recorded tour. path: its floor-plane positions in metres, agent step by agent step; else as `MoverStart`."""

    instance: Text
    path: tuple[Point, ...]
    along_m: Length
    direction: Literal[1, -1]

    @property
    def start(self) -> MoverStart:
        """Its state at the end of the tour."""
        return MoverStart(instance=self.instance, along_m=self.along_m, direction=self.direction)


class Change(Record):
    """One scripted change of one instance between the visits of an episode.

    kind: "enable" for an instance that is gone in visit 1 and present in visit 2, else as `Alteration.kind`. before, after: where
    the instance was at the end of visit 1 and of visit 2, None where it is absent. path: floor-plane positions of a mover, agent
    step by agent step. placement, height_m, lane: how the simulator brings the change about, as `Alteration` has them.
    """

    instance: Text
    kind: Literal["displace", "enable", "disable", "motion"]
    before: Position | None
    after: Position | None
    path: tuple[Point, ...] | None
    placement: Point | None
    height_m: float | None
    lane: Lane | None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        _require(self, self.instance, self.kind, (*_NEEDED.get(self.kind, ()), *(("path",) if self.kind == "motion" else ())))
        return self

    @property
    def in_first_visit(self) -> bool:
        """Whether the alteration holds in visit 1 (an instance that appears is gone there), else in visit 2."""
        return self.kind == "enable"

    @property
    def alteration(self) -> Alteration:
        """What differs from the untouched scene in the visit that the change is made in."""
        if self.kind == "enable":
            return Alteration(kind="disable", instance=self.instance)
        return Alteration(
            kind=self.kind, instance=self.instance, placement=self.placement, height_m=self.height_m, lane=self.lane
        )
