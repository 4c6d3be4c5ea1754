"""Scenes and changes in them: an untouched scene, alterations in the simulator, movers, and the changes of an episode."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ovman.records.geometry import Point, Position
from ovman.records.record import METRE_DECIMALS, Count, InstanceId, Name, Record, Text, optional


class Spare(Record):
    """A second place of a thing of a home, drawn like its own (x, z), metres; yaw_deg: how it is turned there."""

    x: float
    z: float
    yaw_deg: float


class SceneObject(Record):
    """One object of a scene. position, size: centre and size of its axis-aligned box, metres; parents: receptacles it is in.

    Of homes: asset: the shape that it has; yaw_deg: how it is turned; spare: its second place, if it has one.
    """

    id: Text
    category: Text
    moveable: bool
    pickupable: bool
    receptacle: bool
    position: Position
    size: Position
    parents: tuple[str, ...]
    asset: Text | None = optional()
    yaw_deg: float | None = optional()
    spare: Spare | None = optional()

    @property
    def dynamic(self) -> bool:
        """Whether it can be moved or taken."""
        return self.moveable or self.pickupable

    @property
    def place(self) -> Point:
        """The centre of its box on the floor plane, metres."""
        return self.position.x, self.position.z

    @property
    def half(self) -> Point:
        """Half extents of its box along x and z, metres."""
        return self.size.x / 2, self.size.z / 2

    def turned(self, yaw_deg: float | None) -> Self:
        """Return it with the box that it has when it is turned to a multiple of 90 degrees; None: as it is."""
        if yaw_deg is None or self.yaw_deg is None or round((yaw_deg - self.yaw_deg) / 90) % 2 == 0:
            return self
        return self.model_copy(update={"size": self.size.model_copy(update={"x": self.size.z, "z": self.size.x})})

    @property
    def bottom_y(self) -> float:
        """Height of the bottom of its box, metres."""
        return self.position.y - self.size.y / 2

    def moved_to(self, **axes: float) -> Self:
        """Return it with other coordinates of its box's centre."""
        return self.model_copy(update={"position": self.position.model_copy(update=axes)})


class Scene(Record):
    """An untouched scene. Metres, floor plane (x, z).

    start: where AI2-THOR puts the agent; floor_y: height of the floor; reachable: positions that the agent can reach, sorted;
    components: numbers of cells of the connected parts, largest first; waypoints: of a tour, in its order; other_waypoints:
    as many, sampled from another cell, for a second tour that is not the first again; mobile: ids
    of the instances with free floor next to them that the simulator can move by a step; rooms: corners of the floor of each room,
    for homes and houses. In files of floor plans the key is left out.
    """

    schema_id: Literal["ovman-scene/2"] = Field("ovman-scene/2", alias="schema")
    scene: Name
    start: Point
    floor_y: float
    reachable: tuple[tuple[float, float], ...]
    components: tuple[Count, ...]
    waypoints: tuple[Point, ...]
    other_waypoints: tuple[Point, ...]
    mobile: tuple[Text, ...]
    rooms: tuple[tuple[Point, ...], ...] | None = optional()
    objects: tuple[SceneObject, ...]

    def are_off_spares(self, points: np.ndarray, radius_m: float) -> np.ndarray:
        """Return (K,) whether a body of this radius at each of `points` (K, 2) leaves all second places of things free."""
        off = np.ones(len(points), bool)
        for item in self.objects:
            if (spare := item.spare) is not None:
                gaps = np.maximum(np.abs(np.asarray(points) - (spare.x, spare.z)) - item.turned(spare.yaw_deg).half, 0.0)
                off &= np.hypot(*gaps.T) > radius_m
        return off

    def find_rooms(self, points: np.ndarray) -> np.ndarray:
        """Return the number of the room that each of `points` (..., 2) is in, -1 outside; 0 for every point of a floor plan."""
        points = np.asarray(points, float)
        found = np.full(points.shape[:-1], 0 if self.rooms is None else -1)
        for number, corners in enumerate(self.rooms or ()):
            inside = np.zeros(found.shape, bool)
            for (x_0, z_0), (x_1, z_1) in zip(corners, corners[1:] + corners[:1], strict=True):
                if z_0 != z_1:  # the side crosses the ray along +x where the point is between its ends
                    crosses = (z_0 > points[..., 1]) != (z_1 > points[..., 1])
                    inside ^= crosses & (points[..., 0] < x_0 + (points[..., 1] - z_0) * (x_1 - x_0) / (z_1 - z_0))
            found[inside] = number
        return found


HeadingDeg = Literal[0, 90, 180, 270]
"""A heading along the axes of the world, degrees; 0 along +z, 90 along +x."""
Cell = tuple[int, int]
"""(column, row): steps along x and along z from where a mover stood at first."""


class Roam(Record):
    """The floor that a mover roams: free points of the square lattice through (x, z), where the instance stands at first.

    step_m: spacing of the lattice, metres. rows: (row, first, last): `row` steps along z the points from `first` to `last` steps
    along x are free, both included.
    """

    x: float
    z: float
    step_m: Annotated[float, Field(gt=0)]
    rows: tuple[tuple[int, int, int], ...]

    @model_validator(mode="after")
    def _has_its_origin(self) -> Self:
        if (0, 0) not in self.cells:
            raise ValueError("rows hold no (0, 0), where the instance stands")
        return self

    @classmethod
    def over(cls, x: float, z: float, step_m: float, cells: Collection[Cell]) -> Self:
        """Return the floor of these free cells, (0, 0) among them."""
        rows: list[list[int]] = []
        for row, column in sorted((row, column) for column, row in cells):
            if rows and rows[-1][0] == row and rows[-1][2] == column - 1:
                rows[-1][2] = column
            else:
                rows.append([row, column, column])
        return cls(x=x, z=z, step_m=step_m, rows=tuple((row, first, last) for row, first, last in rows))

    @cached_property
    def cells(self) -> frozenset[Cell]:
        """The free points of the lattice."""
        return frozenset((column, row) for row, first, last in self.rows for column in range(first, last + 1))

    def at(self, cell: Cell) -> Point:
        """Floor-plane position of a point of the lattice, metres, rounded as records round it."""
        x, z = self.x + self.step_m * cell[0], self.z + self.step_m * cell[1]
        return round(x, METRE_DECIMALS), round(z, METRE_DECIMALS)

    def cell(self, point: Point) -> Cell:
        """Return the point of the lattice that is nearest to (x, z)."""
        return round((point[0] - self.x) / self.step_m), round((point[1] - self.z) / self.step_m)


_NEEDED: Mapping[str, tuple[str, ...]] = {"displace": ("placement", "height_m"), "motion": ("roam",)}
"""Fields without which the simulator cannot bring a change of that kind about."""


def _require(record: Record, instance: str, kind: str, names: tuple[str, ...]) -> None:
    for name in names:
        if getattr(record, name) is None:
            raise ValueError(f"{kind} of {instance} has no {name}")


class Alteration(Record):
    """One instance that is not as in the untouched scene.

    kind: "displace" (to `placement`, settling under gravity), "disable" (gone) or "motion" (over `roam`, from
    where it stands, or from `placement` where there is one).
    placement: where the centre of the instance's box is put, metres. height_m: the height from which the simulator looks down
    for a surface at the placement. yaw_deg: how it is turned there, None if it keeps its yaw. In files, keys without a value
    are left out.
    """

    kind: Literal["displace", "disable", "motion"]
    instance: InstanceId
    placement: Point | None = optional()
    height_m: float | None = optional()
    yaw_deg: float | None = optional()
    roam: Roam | None = optional()

    @model_validator(mode="after")
    def _complete(self) -> Self:
        _require(self, self.instance, self.kind, _NEEDED.get(self.kind, ()))
        return self


class MoverStart(Record):
    """The state of a mover when a run begins: at the end of the recorded tour of visit 2.

    position: of the centre of its box, metres, a point of its lattice; heading_deg: which way it goes on.
    """

    instance: InstanceId
    position: Point
    heading_deg: HeadingDeg


class MoverRecord(MoverStart):
    """A mover of a recorded tour. path: its floor-plane positions in metres, agent step by agent step; else as `MoverStart`."""

    path: tuple[Point, ...]

    @property
    def start(self) -> MoverStart:
        """Its state at the end of the tour."""
        return MoverStart(instance=self.instance, position=self.position, heading_deg=self.heading_deg)


class Change(Record):
    """One change of one instance between the visits of an episode: scripted for its query, or of another category.

    category: of the instance. kind: "enable" for an instance that is gone in visit 1 and present in visit 2, else as
    `Alteration.kind`. before, after: where the instance was at the end of visit 1 and of visit 2, None where it is absent. path:
    floor-plane positions of a mover, agent step by agent step. placement, height_m, yaw_deg, roam: how the simulator brings the
    change about, as `Alteration` has them.
    """

    instance: InstanceId
    category: Text
    kind: Literal["displace", "enable", "disable", "motion"]
    before: Position | None
    after: Position | None
    path: tuple[Point, ...] | None
    placement: Point | None
    height_m: float | None
    yaw_deg: float | None = optional()
    roam: Roam | None

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
            kind=self.kind,
            instance=self.instance,
            placement=self.placement,
            height_m=self.height_m,
            yaw_deg=self.yaw_deg,
            roam=self.roam,
        )
