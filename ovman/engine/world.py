"""A floor plan and everything that has changed in it since Reset: bodies, the agent, and what stands in whose way.

World frame as in `floorplan`. Actions, errors and messages: AI2-THOR's (contract of the 5.0.0 build), where they differ from
common sense too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ovman.engine.floorplan import Box, FloorPlan, SimObject
from ovman.engine.footprint import Boxes
from ovman.engine.room import Room

AGENT_RADIUS_M = 0.2
AGENT_HEIGHT_M = 1.8
AGENT_CENTRE_M = 0.9
"""Height of the agent's position above the lower end of its capsule."""
SKIN_M = 0.01
"""What the agent's controller keeps between its capsule and whatever blocks it."""
STANDING_CAMERA_M = 0.675
"""Height of the camera above the agent's position; 0 when crouching."""
PASSABLE = frozenset("Floor Window Curtains Blinds Painting LightSwitch Mirror Poster".split())
"""Types whose boxes do not block the agent: hung on a wall, or trodden on."""
WIDE_COUNTER_M = 1.2
"""Counters whose box is at least this wide in plan are L- or U-shaped, and the agent stands in the box's opening."""
DEEPER_M = 1e-6
"""How much deeper into a body that it overlaps already a move may take the agent: rounding."""


class Refused(Exception):
    """An action did not succeed; the message is AI2-THOR's."""


@dataclass(frozen=True)
class Pose:
    """Where an object's pivot is, (3,) metres, and its rotation, (3, 3) from object to world axes."""

    position: np.ndarray
    rotation: np.ndarray


@dataclass
class Agent:
    """AI2-THOR's default agent. Position is the middle of its capsule; horizon positive is down."""

    position: np.ndarray
    yaw_deg: float = 0.0
    horizon_deg: float = 0.0
    standing: bool = True

    @property
    def camera(self) -> np.ndarray:
        """Position of the camera, (3,) metres."""
        return self.position + [0.0, STANDING_CAMERA_M if self.standing else 0.0, 0.0]


@dataclass
class Body:
    """An object as it is now."""

    obj: SimObject
    object_id: str
    name: str
    pose: Pose
    active: bool = True
    removed: bool = False
    dynamic: bool = False
    kinematic: bool = False
    """Put somewhere for good: gravity does not move it."""
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Linear, then angular, m/s and rad/s, world frame."""

    @property
    def untouched(self) -> bool:
        """Whether it is exactly where the floor plan has it."""
        return self.pose.position is self.obj.position and self.pose.rotation is self.obj.rotation

    @property
    def present(self) -> bool:
        return self.active and not self.removed

    @property
    def box(self) -> Box:
        """Current oriented box: it goes with the pose."""
        recorded = self.obj.box
        if self.untouched:
            return recorded
        turn = self.pose.rotation @ self.obj.rotation.T
        centre = self.pose.position + turn @ (recorded.centre - self.obj.position)
        return Box(centre, recorded.half, turn @ recorded.rotation)


class World:
    """The state of one scene. `version` grows whenever a body moves, comes or goes."""

    def __init__(self, plan: FloorPlan, seed: int = 0) -> None:
        self.plan, self.seed = plan, seed
        self.room = Room.of(plan)
        self.agent = Agent(plan.start.copy())
        self.bodies: dict[str, Body] = {
            o.object_id: Body(o, o.object_id, o.name, Pose(o.position, o.rotation), dynamic=o.dynamic) for o in plan.objects
        }
        self.version = 0
        self._walls = Boxes.of([w.box for w in self.room.walls])
        self._covering = _covering(plan)
        self._obstacles_at = -1

    # Boxes and bounds

    def box(self, object_id: str) -> Box:
        """Current oriented box of an object. KeyError if there is none."""
        return self.bodies[object_id].box

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves."""
        return True

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner of the untouched scene, metres."""
        boxes = [o.box.bounds() for o in self.plan.objects]
        low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
        return low, np.maximum(high, [high[0], self.room.ceiling_y, high[2]])

    # The agent's way

    def _obstacles(self) -> tuple[Boxes, list[str]]:
        if self._obstacles_at != self.version:
            bodies = [b for b in self.bodies.values() if self._blocks(b)]
            self._names = [w.name for w in self.room.walls] + [b.object_id for b in bodies]
            self._boxes = self._walls.join(Boxes.of([b.box for b in bodies]))
            self._obstacles_at = self.version
        return self._boxes, self._names

    def _blocks(self, body: Body) -> bool:
        return body.present and body.obj.type not in PASSABLE and not (body.untouched and body.obj.object_id in self._covering)

    def _axis(self) -> tuple[float, float]:
        """Heights of the ends of the axis of the agent's capsule."""
        foot = float(self.agent.position[1]) - AGENT_CENTRE_M
        return foot + AGENT_RADIUS_M, foot + AGENT_HEIGHT_M - AGENT_RADIUS_M

    def blocker(self, start_xz: Sequence[float], end_xz: Sequence[float], ignore: Collection[str] = ()) -> str | None:
        """Name of what the agent's capsule hits on the straight way from `start_xz` to `end_xz`, None if it is free.

        A body that the capsule overlaps at the start does not hold it: it blocks only ways that lead deeper into it.
        """
        boxes, names = self._obstacles()
        low, high = self._axis()
        start, end = np.array(start_xz, dtype=float), np.array(end_xz, dtype=float)
        reach = AGENT_RADIUS_M + SKIN_M
        length = float(np.linalg.norm(end - start))
        at_start = boxes.distances(start[None], low, high, reach + length)[0]
        near = np.nonzero(at_start < reach + length)[0]
        if ignore:
            near = near[[names[i] not in ignore for i in near]]
        if not len(near):
            return None
        nearest = boxes.sweeps(np.tile(start, (len(near), 1)), np.tile(end, (len(near), 1)), near, low, high)
        hit = near[nearest < np.minimum(reach, at_start[near] - DEEPER_M)]
        return names[hit[at_start[hit].argmin()]] if len(hit) else None

    def reachable(self, step_m: float = 0.25) -> list[tuple[float, float, float]]:
        """Positions that the agent can reach by moves of `step_m` along world x and z, its own first; y is the agent's."""
        boxes, _ = self._obstacles()
        low, high = self._axis()
        reach = AGENT_RADIUS_M + SKIN_M
        boxes = boxes.take((boxes.low < high + reach) & (boxes.high > low - reach))
        here = self.agent.position[[0, 2]]
        x_0, z_0, x_1, z_1 = self.room.rectangle
        first = np.minimum(np.ceil((np.array([x_0, z_0]) - here) / step_m).astype(int), 0)
        last = np.maximum(np.floor((np.array([x_1, z_1]) - here) / step_m).astype(int), 0)
        shape = tuple(last - first + 1)
        cells = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij"), axis=-1)
        points = (here + step_m * cells).reshape(-1, 2)
        clearance = boxes.distances(points, low, high, reach + step_m)
        free = (clearance >= reach).all(axis=1)
        number = np.arange(len(points)).reshape(shape)
        edges = np.concatenate(
            [
                np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
                np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
            ]
        )
        edges = edges[free[edges].all(axis=1)]
        # The distance to a convex body is convex along the way: no way between two points that are far enough apart from it
        # together can come close.
        edge, box = np.nonzero(clearance[edges[:, 0]] + clearance[edges[:, 1]] < 2 * reach + step_m)
        if len(edge):
            pair = edges[edge]
            hit = boxes.sweeps(points[pair[:, 0]], points[pair[:, 1]], box, low, high) < reach
            edges = np.delete(edges, np.unique(edge[hit]), axis=0)
        graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(len(points), len(points)))
        label = connected_components(graph, directed=False)[1]
        found = self._flood(points, number, free, label, tuple(-first))
        y = float(self.agent.position[1])
        return [(float(points[i, 0]), y, float(points[i, 1])) for i in found]

    def _flood(
        self, points: np.ndarray, number: np.ndarray, free: np.ndarray, label: np.ndarray, own: tuple[int, int]
    ) -> list[int]:
        """Cells reachable from `own`: whole components of free cells, and ways out of cells in which the capsule overlaps something."""
        seen, queue, entered = {int(number[own])}, [own], set()
        while queue:
            cell = queue.pop(0)
            index = int(number[cell])
            if free[index]:
                if label[index] not in entered:
                    entered.add(label[index])
                    seen.update(int(i) for i in np.nonzero((label == label[index]) & free)[0])
                continue
            for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                following = (cell[0] + i, cell[1] + j)
                if not (0 <= following[0] < number.shape[0] and 0 <= following[1] < number.shape[1]):
                    continue
                target = int(number[following])
                if target not in seen and self.blocker(points[index], points[target]) is None:
                    seen.add(target)
                    queue.append(following)
        own_index = int(number[own])
        return [own_index, *sorted(seen - {own_index})]

    # Changes

    def set_active(self, object_id: str, active: bool) -> None:
        """DisableObject, EnableObject. Refused with an empty message if there is no such object."""
        body = self.bodies.get(object_id)
        if body is None:
            raise Refused("")
        if body.active != active:
            body.active = active
            self.version += 1

    def remove(self, object_id: str) -> None:
        """RemoveFromScene: gone until Reset."""
        if object_id not in self.bodies or self.bodies[object_id].removed:
            raise Refused("NullReferenceException: Object reference not set to an instance of an object")
        self.bodies[object_id].removed = True
        self.version += 1

    def teleport(
        self,
        object_id: str,
        position: Sequence[float],
        rotation: np.ndarray | None = None,
        force: bool = False,
        kinematic: bool = False,
    ) -> None:
        """TeleportObject: exactly there."""
        body = self._known(object_id)
        self._put(body, Pose(np.array(position, dtype=float), body.pose.rotation if rotation is None else rotation))
        body.kinematic = kinematic

    def place(
        self, object_id: str, position: Sequence[float], rotation: np.ndarray | None = None, kinematic: bool = False
    ) -> np.ndarray:
        """PlaceObjectAtPoint: on the surface below `position`. Returns the position of the pivot at rest, (3,) metres."""
        body = self._known(object_id)
        point = np.array(position, dtype=float)
        low, high = self.bounds()
        if not ((point >= low - 1e-6) & (point <= high + 1e-6)).all():
            raise Refused(f"Position coordinate ({point[0]:.1f}, {point[1]:.1f}, {point[2]:.1f}) is not within scene bounds")
        surface = self.plan.floor_y
        for other in self.bodies.values():
            if other is body or not other.present or other.obj.type == "Floor":
                continue
            box_low, box_high = other.box.bounds()
            inside = box_low[0] <= point[0] <= box_high[0] and box_low[2] <= point[2] <= box_high[2]
            if inside and surface < box_high[1] <= point[1]:
                surface = float(box_high[1])
        turned = body.pose.rotation if rotation is None else rotation
        self._put(body, Pose(point, turned))
        lift = surface + 0.005 - float(body.box.bounds()[0][1])
        self._put(body, Pose(point + [0.0, lift, 0.0], turned))
        body.kinematic = kinematic
        return body.pose.position

    def set_poses(self, poses: Sequence[Mapping[str, object]], stationary: bool = True) -> None:
        """SetObjectPoses: [{objectName, position (3,), rotation (3, 3)}, ...]; every other movable object goes."""
        listed = {p["objectName"] for p in poses}
        for body in self.bodies.values():
            if body.dynamic and body.name not in listed:
                body.active = False
        by_name = {b.name: b for b in self.bodies.values()}
        for pose in poses:
            body = by_name.get(pose["objectName"])
            if body is not None:
                body.active = True
                self._put(body, Pose(np.array(pose["position"], dtype=float), np.array(pose["rotation"], dtype=float)))
        self.version += 1

    def advance(self, seconds: float) -> None:
        """Let physics run. Costs nothing while everything is at rest."""

    def _known(self, object_id: str) -> Body:
        body = self.bodies.get(object_id)
        if body is None or body.removed:
            raise Refused(f"Cannot find object with id {object_id}.")
        return body

    def _put(self, body: Body, pose: Pose) -> None:
        body.pose = pose
        self.version += 1


def _covering(plan: FloorPlan) -> frozenset[str]:
    """Objects whose boxes are known to be larger than they are: those that cover the start, and counters with an opening."""
    low, high = plan.start[1] - AGENT_CENTRE_M + AGENT_RADIUS_M, plan.start[1] - AGENT_CENTRE_M + AGENT_HEIGHT_M - AGENT_RADIUS_M
    objects = [o for o in plan.objects if o.type not in PASSABLE]
    at_start = Boxes.of([o.box for o in objects]).distances(plan.start[None, [0, 2]], low, high, AGENT_RADIUS_M)[0]
    covering = {o.object_id for o, distance in zip(objects, at_start, strict=True) if distance == 0.0}
    for o in objects:
        first, last = o.box.bounds()
        if o.type == "CounterTop" and min((last - first)[[0, 2]]) > WIDE_COUNTER_M:
            covering.add(o.object_id)
    return frozenset(covering)
