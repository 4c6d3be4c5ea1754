"""Scripted changes: brings alterations about in the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.records.change import Alteration, MoverStart
from ovman.records.geometry import Point, Position
from ovman.settings.benchmark import Mover as MoverParams
from ovman.sim.mover import Mover, streams
from ovman.sim.session import Session, SimulatorError

AGENT_RADIUS_M = 0.2
"""Radius of AI2-THOR's default agent, metres."""
STANDS_M = 0.02
"""An instance farther than this from where its walk is to begin does not stand there."""
LIFTED_M = 0.01
"""So high above where it stands an instance does not touch the floor."""


def position(metadata: Mapping[str, Any]) -> Position:
    """Position of an object: the centre of its axis-aligned box, metres, to 0.1 mm.

    metadata: of the object in AI2-THOR's event. AI2-THOR's own "position" is the pivot, which lies outside some objects; the
    centre of the box is what the observations show.
    """
    centre = metadata["axisAlignedBoundingBox"]["center"]
    return Position(x=round(float(centre["x"]), 4), y=round(float(centre["y"]), 4), z=round(float(centre["z"]), 4))


def dynamic(metadata: Mapping[str, Any]) -> bool:
    """Whether an object can be moved or taken, by its metadata; all others stay where the scene has them."""
    return bool(metadata["moveable"] or metadata["pickupable"])


@dataclass(frozen=True)
class _Body:
    """What it takes to teleport a mover. offset: from the centre of its box to its pivot, metres; clearance_m: the agent keeps it
    from coming nearer."""

    rotation: Mapping[str, float]
    pivot_y: float
    offset: tuple[float, float]
    clearance_m: float


class World:
    """A scene in the state of one visit: applies alterations to a freshly reset session, and drives the movers that are set off.

    rng: drives the first mover; every further one has a stream of its own, which is spawned from it, so that the walk of one does
    not depend on how many there are. object_filter: given the metadata of an object in the untouched scene, whether later events
    report it; None for all. Metadata are most of the cost of a change. placed: positions right after placement by instance;
    movers, paths: the movers and their floor-plane positions in metres, agent step by agent step, by instance. Raises
    SimulatorError if the simulator refuses an alteration.
    """

    def __init__(
        self,
        session: Session,
        alterations: Sequence[Alteration],
        params: MoverParams,
        rng: np.random.Generator,
        object_filter: Callable[[Mapping[str, Any]], bool] | None = None,
    ) -> None:
        self._session, self._params = session, params
        moving = [alteration.instance for alteration in alterations if alteration.kind == "motion"]
        self._streams = dict(zip(moving, streams(rng, len(moving)), strict=True))
        self._bodies: dict[str, _Body] = {}
        self.placed: dict[str, Position] = {}
        self.movers: dict[str, Mover] = {}
        self.paths: dict[str, list[Point]] = {}
        session.reset()
        altered = {alteration.instance for alteration in alterations}
        reported = None if object_filter is None else {k for k, o in session.objects.items() if object_filter(o)}
        if reported is not None:
            session.filter_objects(reported | altered)
        for alteration in alterations:
            self._apply(alteration)
        session.settle()
        if reported is not None and not altered <= reported:
            session.filter_objects(reported)

    def _apply(self, alteration: Alteration) -> None:
        if alteration.kind == "disable":
            self._session.step("DisableObject", objectId=alteration.instance)
        elif alteration.kind == "displace":
            assert alteration.placement is not None and alteration.height_m is not None
            self._place(alteration.instance, alteration.placement, alteration.height_m)
        else:
            assert alteration.roam is not None
            if alteration.placement is not None and alteration.height_m is not None:
                self._place(alteration.instance, alteration.placement, alteration.height_m)
                self._session.settle()
            self._set_off(alteration.instance, Mover.setting_off(alteration.roam, self._streams[alteration.instance]))

    def _place(self, instance: str, point: Point, height_m: float) -> None:
        metadata = self._session.objects[instance]
        pivot, centre = metadata["position"], metadata["axisAlignedBoundingBox"]["center"]
        self._session.step(
            "PlaceObjectAtPoint",
            objectId=instance,
            position={"x": point[0] + pivot["x"] - centre["x"], "y": height_m, "z": point[1] + pivot["z"] - centre["z"]},
            rotation=metadata["rotation"],
            forceKinematic=False,
        )
        self.placed[instance] = position(self._session.objects[instance])

    def _set_off(self, instance: str, mover: Mover) -> None:
        metadata = self._session.objects[instance]
        pivot, box = metadata["position"], metadata["axisAlignedBoundingBox"]
        stands, begins = (box["center"]["x"], box["center"]["z"]), mover.position
        if math.dist(stands, begins) > STANDS_M and instance not in self.placed:
            raise SimulatorError(f"{self._session.scene}: {instance} stands at {stands}, not at {begins}, where its walk begins")
        self._bodies[instance] = _Body(
            metadata["rotation"],
            pivot["y"],
            (pivot["x"] - box["center"]["x"], pivot["z"] - box["center"]["z"]),
            AGENT_RADIUS_M + math.hypot(box["size"]["x"], box["size"]["z"]) / 2,
        )
        if not any(self._teleport(instance, mover.roam.at(cell), lifted_m=LIFTED_M) for cell in mover.neighbours()):
            raise SimulatorError(f"{self._session.scene}: {instance} cannot move from where it stands: every way is barred")
        self.paths[instance] = []
        self._move(instance, mover)

    def _teleport(self, instance: str, point: Point, lifted_m: float = 0.0) -> bool:
        """Put a mover's centre at a point, whatever is there; lifted off the floor, only where it touches nothing."""
        body, (x, z) = self._bodies[instance], point
        event = self._session.step(
            "TeleportObject",
            allowed=lifted_m > 0.0,
            objectId=instance,
            position={"x": x + body.offset[0], "y": body.pivot_y + lifted_m, "z": z + body.offset[1]},
            rotation=body.rotation,
            forceAction=lifted_m == 0.0,
            forceKinematic=True,
        )
        return bool(event.metadata["lastActionSuccess"])

    def _move(self, instance: str, mover: Mover) -> None:
        self._teleport(instance, mover.position)
        self.movers[instance] = mover
        self.paths[instance].append(mover.position)

    def send_movers_to(self, starts: Sequence[MoverStart]) -> None:
        """Put movers where a recorded visit left them; their paths start anew there."""
        for start in starts:
            self.paths[start.instance] = []
            self._move(start.instance, self.movers[start.instance].resumed(start))

    def after_action(self) -> None:
        """Let every mover take its step. To be called after every action of the agent."""
        if not self.movers:
            return
        here = self._session.pose
        for instance, mover in list(self.movers.items()):
            clearance_m = self._bodies[instance].clearance_m
            after = mover.advance(self._params, self._streams[instance], (here.x, here.z), clearance_m)
            if after.cell == mover.cell:
                self.movers[instance] = after
                self.paths[instance].append(self.paths[instance][-1])
            else:
                self._move(instance, after)
