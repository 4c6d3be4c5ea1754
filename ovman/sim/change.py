"""Scripted changes: what differs from the untouched scene in a visit, and how it is brought about in the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.sim.mover import Gait, Lane, Mover
from ovman.sim.session import Session

AGENT_RADIUS_M = 0.2
"""Radius of AI2-THOR's default agent."""


@dataclass(frozen=True)
class Alteration:
    """One instance that is not as in the untouched scene.

    `kind` is "displace" (to `placement`, settling under gravity), "disable" (gone) or "motion" (put on `lane`, then going).
    `placement` is where the centre of the instance's box is put, (x, z), and `height_m` the height from which the simulator looks
    down for a surface to put it on, there or at the beginning of the lane.
    """

    kind: str
    instance: str
    placement: tuple[float, float] | None = None
    height_m: float | None = None
    lane: Lane | None = None

    @staticmethod
    def from_json(record: Mapping[str, Any]) -> Alteration:
        placement, lane = record.get("placement"), record.get("lane")
        return Alteration(
            record["kind"],
            record["instance"],
            None if placement is None else (placement["x"], placement["z"]),
            record.get("height_m"),
            None if lane is None else Lane(**lane),
        )

    def to_json(self) -> dict[str, Any]:
        record: dict[str, Any] = {"kind": self.kind, "instance": self.instance}
        if self.placement is not None:
            record["placement"] = {"x": self.placement[0], "z": self.placement[1]}
        if self.height_m is not None:
            record["height_m"] = self.height_m
        if self.lane is not None:
            record["lane"] = {"x_0": self.lane.x_0, "z_0": self.lane.z_0, "x_1": self.lane.x_1, "z_1": self.lane.z_1}
        return record


def position(metadata: Mapping[str, Any]) -> dict[str, float]:
    """Position of an instance: the centre of its axis-aligned box, metres, to 0.1 mm.

    The pivot that AI2-THOR calls position lies outside some objects; the centre of the box is what the observations show.
    """
    centre = metadata["axisAlignedBoundingBox"]["center"]
    return {axis: round(float(centre[axis]), 4) for axis in "xyz"}


def dynamic(metadata: Mapping[str, Any]) -> bool:
    """Whether an instance can be moved or taken: the others are where the scene has them."""
    return bool(metadata["moveable"] or metadata["pickupable"])


class World:
    """A scene in the state of one visit: applies alterations to a freshly reset session and drives the mover, if there is one.

    told: of which objects the session goes on being told, by their metadata in the untouched scene; None for all. Metadata are
    most of what a change costs.
    """

    def __init__(
        self,
        session: Session,
        alterations: Sequence[Alteration],
        gait: Gait,
        rng: np.random.Generator,
        told: Callable[[Mapping[str, Any]], bool] | None = None,
    ) -> None:
        self._session, self._gait, self._rng = session, gait, rng
        self.placed: dict[str, dict[str, float]] = {}
        self.mover: Mover | None = None
        self.mover_id: str | None = None
        self.path: list[tuple[float, float]] = []
        session.reset()
        altered = {alteration.instance for alteration in alterations}
        attended = None if told is None else {k for k, o in session.objects.items() if told(o)}
        if attended is not None:
            session.attend(attended | altered)
        for alteration in alterations:
            self._apply(alteration)
        session.settle()
        if attended is not None and not altered <= attended:
            session.attend(attended)

    def _apply(self, alteration: Alteration) -> None:
        if alteration.kind == "disable":
            self._session.step("DisableObject", objectId=alteration.instance)
        elif alteration.kind == "displace":
            assert alteration.placement is not None and alteration.height_m is not None
            self._place(alteration.instance, alteration.placement, alteration.height_m, kinematic=False)
        elif alteration.kind == "motion":
            assert alteration.lane is not None and alteration.height_m is not None
            self._place(alteration.instance, (alteration.lane.x_0, alteration.lane.z_0), alteration.height_m, kinematic=True)
            self._set_off(alteration.instance, Mover(alteration.lane))
        else:
            raise ValueError(f"unknown kind of alteration: {alteration.kind!r}")

    def _place(self, instance: str, point: tuple[float, float], height_m: float, kinematic: bool) -> None:
        metadata = self._session.objects[instance]
        pivot, centre = metadata["position"], metadata["axisAlignedBoundingBox"]["center"]
        self._session.step(
            "PlaceObjectAtPoint",
            objectId=instance,
            position={"x": point[0] + pivot["x"] - centre["x"], "y": height_m, "z": point[1] + pivot["z"] - centre["z"]},
            rotation=metadata["rotation"],
            forceKinematic=kinematic,
        )
        self.placed[instance] = position(self._session.objects[instance])

    def _set_off(self, instance: str, mover: Mover) -> None:
        metadata = self._session.objects[instance]
        pivot, box = metadata["position"], metadata["axisAlignedBoundingBox"]
        self.mover, self.mover_id = mover, instance
        self._rotation = metadata["rotation"]
        self._pivot_y = pivot["y"]
        self._offset = (pivot["x"] - box["center"]["x"], pivot["z"] - box["center"]["z"])
        self._clearance_m = AGENT_RADIUS_M + math.hypot(box["size"]["x"], box["size"]["z"]) / 2
        self._move(mover)

    def _move(self, mover: Mover) -> None:
        x, z = mover.position
        self._session.step(
            "TeleportObject",
            objectId=self.mover_id,
            position={"x": x + self._offset[0], "y": self._pivot_y, "z": z + self._offset[1]},
            rotation=self._rotation,
            forceAction=True,
            forceKinematic=True,
        )
        self.mover = mover
        self.path.append((round(x, 4), round(z, 4)))

    def send_mover_to(self, along_m: float, direction: int) -> None:
        """Put the mover where a recorded visit left it; its path begins anew there."""
        assert self.mover is not None
        self.path = []
        self._move(Mover(self.mover.lane, along_m, direction))

    def after_action(self) -> None:
        """To be called after every action of the agent: the mover takes its step."""
        if self.mover is not None:
            here = self._session.pose
            after = self.mover.advance(self._gait, self._rng, (here.x, here.z), self._clearance_m)
            if after.position == self.mover.position:
                self.mover = after
                self.path.append(self.path[-1])
            else:
                self._move(after)
