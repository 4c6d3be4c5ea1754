"""The world of a visit: applies scripted alterations in the simulator and drives the movers.

A mover is an object that walks at random over free floor while the agent acts (MOVING episodes). It starts where it stands. For
every action of the agent (views of a tour count as actions) it goes one step of its lattice along its heading, pauses or turns at
random, turns where its way is barred, and stays if every way is. It is teleported as a kinematic body, so it pushes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ovman.records.geometry import Point, Position
from ovman.records.scene import Alteration, Cell, HeadingDeg, MoverStart, Roam
from ovman.settings.benchmark import Mover as MoverParams
from ovman.sim.session import Session, SimulatorError

WAYS: Mapping[HeadingDeg, Cell] = {0: (0, 1), 90: (1, 0), 180: (0, -1), 270: (-1, 0)}
"""The steps of a lattice, (along x, along z), by their headings."""
AGENT_RADIUS_M = 0.2
"""Radius of AI2-THOR's default agent, metres."""
STANDS_M = 0.02
"""An instance farther than this from the start of its walk does not stand there."""
LIFTED_M = 0.01
"""Lifted this high, an instance does not touch the floor."""


def spawn_streams(rng: np.random.Generator, number: int) -> list[np.random.Generator]:
    """Return the streams of the movers of one tour or run: `rng` itself, and streams spawned from it.

    The walk of one mover therefore does not depend on the number of movers.
    """
    return [rng, *rng.spawn(number - 1)] if number else []


@dataclass(frozen=True)
class Mover:
    """State of a mover: its point of the lattice, and its heading."""

    roam: Roam
    cell: Cell = (0, 0)
    heading_deg: HeadingDeg = 0

    @staticmethod
    def setting_off(roam: Roam, rng: np.random.Generator) -> Mover:
        """Return a mover where the instance stands, with a drawn heading."""
        return Mover(roam, heading_deg=list(WAYS)[int(rng.integers(len(WAYS)))])

    def resumed(self, start: MoverStart) -> Mover:
        """Return the mover in the state in which a recorded visit left it. ValueError for a place off its floor."""
        cell = self.roam.cell(start.position)
        if cell not in self.roam.cells:
            raise ValueError(f"{start.instance} is at {start.position}, off the floor that it roams")
        return Mover(self.roam, cell, start.heading_deg)

    @property
    def position(self) -> Point:
        """Floor-plane position in metres."""
        return self.roam.at(self.cell)

    def neighbours(self) -> list[Cell]:
        """Return the free points of the lattice one step away."""
        return [cell for heading in WAYS if (cell := self._next(heading)) in self.roam.cells]

    def advance(
        self, params: MoverParams, rng: np.random.Generator, keep_clear_of: Point | None = None, clearance_m: float = 0.0
    ) -> Mover:
        """Return the mover after one agent action.

        params: pause_probability and turn_probability. Always draws the same number of variates, so that the walk under
        a seed depends on the agent only where it is in the way: a step that would come closer than `clearance_m` to the agent at
        `keep_clear_of` is barred.
        """
        pause, turn, choice = rng.random(3)
        if pause < params.pause_probability:
            return self
        free = [heading for heading in WAYS if self._free(heading, keep_clear_of, clearance_m)]
        if self.heading_deg in free and turn >= params.turn_probability:
            return replace(self, cell=self._next(self.heading_deg))
        ways = [heading for heading in free if heading != self.heading_deg] or free
        if not ways:
            return self
        heading = ways[int(choice * len(ways))]
        return Mover(self.roam, self._next(heading), heading)

    def _next(self, heading: HeadingDeg) -> Cell:
        columns, rows = WAYS[heading]
        return self.cell[0] + columns, self.cell[1] + rows

    def _free(self, heading: HeadingDeg, agent: Point | None, clearance_m: float) -> bool:
        cell = self._next(heading)
        if cell not in self.roam.cells:
            return False
        if agent is None:
            return True
        then_m = math.dist(self.roam.at(cell), agent)
        return then_m >= clearance_m or then_m >= math.dist(self.position, agent)


def walk(mover: Mover, params: MoverParams, rng: np.random.Generator, steps: int) -> Iterator[Mover]:
    """Yield the mover after each of `steps` agent actions with no agent in its way."""
    for _ in range(steps):
        mover = mover.advance(params, rng)
        yield mover


def position(metadata: Mapping[str, Any]) -> Position:
    """Return the position of an object from its metadata: the centre of its axis-aligned box, metres, to 0.1 mm.

    AI2-THOR's own "position" is the pivot, which lies outside some objects; observations show the centre of the box.
    """
    centre = metadata["axisAlignedBoundingBox"]["center"]
    return Position(x=round(float(centre["x"]), 4), y=round(float(centre["y"]), 4), z=round(float(centre["z"]), 4))


def is_dynamic(metadata: Mapping[str, Any]) -> bool:
    """Return whether an object can be moved or taken, by its metadata; all others keep their places."""
    return bool(metadata["moveable"] or metadata["pickupable"])


def _turn(offset: Point, by_deg: float) -> Point:
    """Return (x, z) turned clockwise as seen from above."""
    sine, cosine = math.sin(math.radians(by_deg)), math.cos(math.radians(by_deg))
    return offset[0] * cosine + offset[1] * sine, offset[1] * cosine - offset[0] * sine


@dataclass(frozen=True)
class _Body:
    """The body of a mover. offset: from the centre of its box to its pivot, metres; clearance_m: distance kept to the agent."""

    rotation: Mapping[str, float]
    pivot_y: float
    offset: tuple[float, float]
    clearance_m: float


class World:
    """A scene in the state of one visit: resets the session, applies alterations, and drives the movers.

    rng: of the movers (`spawn_streams`). object_filter: selects by metadata the objects that later events report; None for all.
    Metadata are most of the cost of a change. placed: positions right after placement by instance; movers, paths: the movers and
    their floor-plane positions in metres, one per agent step, by instance. SimulatorError if the simulator refuses an alteration.
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
        self._streams = dict(zip(moving, spawn_streams(rng, len(moving)), strict=True))
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
            self._place(alteration.instance, alteration.placement, alteration.height_m, alteration.yaw_deg)
        else:
            assert alteration.roam is not None
            if alteration.placement is not None and alteration.height_m is not None:
                self._place(alteration.instance, alteration.placement, alteration.height_m)
                self._session.settle()
            self._set_off(alteration.instance, Mover.setting_off(alteration.roam, self._streams[alteration.instance]))

    def _place(self, instance: str, point: Point, height_m: float, yaw_deg: float | None = None) -> None:
        metadata = self._session.objects[instance]
        pivot, centre, rotation = metadata["position"], metadata["axisAlignedBoundingBox"]["center"], metadata["rotation"]
        offset = pivot["x"] - centre["x"], pivot["z"] - centre["z"]
        if yaw_deg is not None:
            offset = _turn(offset, yaw_deg - rotation["y"])
            rotation = {**rotation, "y": yaw_deg}
        self._session.step(
            "PlaceObjectAtPoint",
            objectId=instance,
            position={"x": point[0] + offset[0], "y": height_m, "z": point[1] + offset[1]},
            rotation=rotation,
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
        """Put a mover's centre at a point, whatever is there; a lifted one only if it touches nothing."""
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
        """Put movers where a recorded visit left them; their paths start again there."""
        for start in starts:
            self.paths[start.instance] = []
            self._move(start.instance, self.movers[start.instance].resumed(start))

    def after_action(self) -> None:
        """Let every mover take its step. Call it after every action of the agent."""
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
