"""A world as AI2-THOR's metadata. Untouched objects are reported with exactly the numbers of their record."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ovman_engine.bodies.body import Body
from ovman_engine.bodies.footprint import Boxes
from ovman_engine.bodies.surfaces import VESSELS
from ovman_engine.client.settings import Settings
from ovman_engine.plan.floorplan import Box, euler_degrees
from ovman_engine.plan.vector import vector
from ovman_engine.sight.visibility import Eye, Sight, Spheres
from ovman_engine.world.world import World

ABOVE_M, BELOW_M = 0.05, 0.02
"""An object is on or in a receptacle if the middle of its underside is in the receptacle's box, or this far above or below it."""


class SceneMetadata:
    """The metadata of one world. Records are rebuilt only for bodies that changed, visibility only after a movement."""

    def __init__(self, world: World) -> None:
        """Describe `world`, now and after later changes."""
        self._world = world
        low, high = world.bounds()
        self._bounds = {**_aligned((low + high) / 2, high - low), "cornerPoints": _corners(low, high)}
        self._version: tuple[int, bool] | None = None
        self._seen_from: tuple[Any, ...] | None = None
        self._records: dict[str, dict[str, Any]] = {}
        self._boxes: dict[str, Box] = {}
        self._made_of: dict[str, tuple[Any, ...]] = {}
        self._rearranged = False
        self._sight: Sight | None = None
        self._sight_of = -1
        self._moving = False

    def state(self, settings: Settings, aspect: float) -> dict[str, Any]:
        """Return the keys of an event that describe the world, its agent and its objects.

        Lists and dicts are reused: serialise them before the world changes.
        """
        agent = self._world.agent
        objects = self._objects(settings, aspect)
        if settings.shown is not None:
            objects = [o for o in objects if o["objectId"] in settings.shown]
        return {
            "objects": objects,
            "isSceneAtRest": not self._moving,
            "agent": {
                "name": "agent",
                "position": vector(*agent.position),
                "rotation": vector(0.0, agent.yaw_deg, 0.0),
                "cameraHorizon": float(agent.horizon_deg),
                "isStanding": bool(agent.standing) if agent.embodiment.crouches else None,
                "inHighFrictionArea": False,
            },
            "cameraPosition": vector(*agent.camera),
            "sceneBounds": self._bounds,
        }

    def _objects(self, settings: Settings, aspect: float) -> list[dict[str, Any]]:
        world, agent = self._world, self._world.agent
        version = (world.version, world.at_rest)
        if self._version != version:
            self._refresh()
            self._version = version
            self._seen_from = None
        view = (settings.field_of_view_deg, settings.visibility_m, settings.visibility_scheme, aspect)
        seen_from = (*agent.position, agent.yaw_deg, agent.horizon_deg, agent.standing, agent.embodiment, *view, settings.shown)
        # Visibility takes longer than all other metadata; it is skipped while no object is listed.
        if self._seen_from != seen_from and settings.shown != frozenset():
            self._look(Eye.of(agent, settings.field_of_view_deg, aspect), settings)
            self._seen_from = seen_from
        return self._list

    @property
    def sight(self) -> Sight:
        """What can be seen in the world as it is now."""
        if self._sight is None or self._sight_of != self._world.version:
            self._sight, self._sight_of = Sight(self._world), self._world.version
        return self._sight

    def _refresh(self) -> None:
        bodies = [b for b in self._world.bodies.values() if not b.removed]
        for body in bodies:
            made_of = (body.object_id, body.name, body.pose.position, body.pose.rotation)
            old = self._made_of.get(body.object_id)
            if old is None or any(a is not b for a, b in zip(made_of, old, strict=True)):
                self._boxes[body.object_id] = body.box
                self._records[body.object_id] = object_record(body)
                self._made_of[body.object_id] = made_of
            # A released body has no velocity before it falls; a body that falls or rolls always has one.
            self._records[body.object_id]["isMoving"] = bool(body.velocity.any())
        if len(self._records) > len(bodies):
            self._forget(self._records.keys() - {b.object_id for b in bodies})
        self._list = [self._records[b.object_id] for b in bodies]
        self._moving = any(record["isMoving"] for record in self._list)
        self._positions = np.array([b.pose.position for b in bodies]).reshape(-1, 3)
        self._keep_receptacles(bodies)

    def _forget(self, names: set[str]) -> None:
        for kept in (self._records, self._boxes, self._made_of):
            for name in names:
                kept.pop(name, None)

    def _look(self, eye: Eye, settings: Settings) -> None:
        towards = (
            None if settings.shown is None else Spheres.around(self._world, settings.shown).within(eye, settings.visibility_m)
        )
        visible: set[str] = set()
        interactable: set[str] = set()
        if towards is None or len(towards.radii):
            visible, interactable = self.sight.visible(eye, settings.visibility_m, settings.visibility_scheme, towards)
        distances = np.linalg.norm(self._positions - self._world.agent.position, axis=1).tolist()
        for record, distance in zip(self._list, distances, strict=True):
            record["distance"] = distance
            record["visible"] = record["objectId"] in visible
            record["isInteractable"] = record["objectId"] in interactable

    def _keep_receptacles(self, bodies: list[Body]) -> None:
        """Update which object is on or in which receptacle: as recorded between untouched objects, by their boxes otherwise."""
        there = {b.object_id: b for b in bodies if b.active}
        changed = {name for name, b in there.items() if not b.untouched or name != b.obj.object_id}
        if changed or len(there) < len(self._world.plan.objects):
            self._rearranged = True
        elif not self._rearranged:
            return
        still = there.keys() - changed
        children: dict[str, list[str]] = {b.object_id: [] for b in bodies}
        parents: dict[str, list[str]] = {b.object_id: [] for b in bodies}
        for name in still:
            children[name] = [c for c in there[name].obj.record["receptacleObjectIds"] or () if c in still]
            parents[name] = [p for p in there[name].obj.parents if p in still]
        active = _flags(b.active for b in bodies)
        new = _flags(b.object_id in changed for b in bodies)
        holds = active & _flags(b.obj.record["receptacle"] for b in bodies)
        floor = _flags(b.obj.type == "Floor" for b in bodies)
        vessel = _flags(b.obj.type in VESSELS for b in bodies)
        boxes = Boxes.of([self._boxes[b.object_id] for b in bodies])
        holder, held = np.nonzero(_resting(boxes, floor, vessel, self._world.plan.floor_y) & holds[:, None] & active)
        for h, o in zip(holder, held, strict=True):
            if h != o and (new[h] or new[o]):
                children[bodies[h].object_id].append(bodies[o].object_id)
                parents[bodies[o].object_id].append(bodies[h].object_id)
        for body in bodies:
            record = self._records[body.object_id]
            record["parentReceptacles"] = parents[body.object_id] or None
            record["receptacleObjectIds"] = children[body.object_id] if body.obj.record["receptacle"] else None


def object_record(body: Body) -> dict[str, Any]:
    """Return the 42 keys of an object. Those that depend on the agent are as recorded."""
    record = {**body.obj.record, "objectId": body.object_id, "name": body.name}
    if body.untouched:
        return record
    pose, obj = body.pose, body.obj
    record["position"] = vector(*pose.position)
    record["rotation"] = vector(*euler_degrees(pose.rotation))
    turn = pose.rotation @ obj.rotation.T
    oriented = obj.record["objectOrientedBoundingBox"]
    low, high = body.box.bounds()
    if oriented is not None:
        points = (np.array(oriented["cornerPoints"]) - obj.position) @ turn.T + pose.position
        record["objectOrientedBoundingBox"] = {"cornerPoints": points.tolist()}
    record["axisAlignedBoundingBox"] = {"cornerPoints": _corners(low, high), **_aligned((low + high) / 2, high - low)}
    return record


def _flags(values: Iterable[bool]) -> np.ndarray:
    """(N,) bool. Without the type, NumPy makes numbers of an empty list, and a scene may have no objects."""
    return np.array(list(values), dtype=bool)


def _aligned(centre: np.ndarray, size: np.ndarray) -> dict[str, Any]:
    return {"center": vector(*centre), "size": vector(*size)}


def _corners(low: np.ndarray, high: np.ndarray) -> list[list[float]]:
    """Return the corners (8, 3) of a box, in AI2-THOR's order."""
    return [[float(x), float(y), float(z)] for x in (high[0], low[0]) for y in (high[1], low[1]) for z in (high[2], low[2])]


def _resting(boxes: Boxes, floor: np.ndarray, vessel: np.ndarray, floor_y: float) -> np.ndarray:
    """(N, N) bool: whether the object of the row holds that of the column, as a receptacle.

    `floor` and `vessel` (N,) say which rows are floors, and which contain objects.

    The floor holds what stands on it, even within the box of a table, but not what lies in a bin.
    """
    reach = np.einsum("nij,nj->ni", np.abs(boxes.rotation), boxes.half)
    foot = boxes.centre - reach * [0.0, 1.0, 0.0]
    on_floor = foot[:, 1] < floor_y + ABOVE_M
    probe = foot - [0.0, (ABOVE_M - BELOW_M) / 2, 0.0]
    local = np.einsum("nij,nki->nkj", boxes.rotation, probe[None] - boxes.centre[:, None])
    slack = np.abs(boxes.rotation[:, 1, :]) * (ABOVE_M + BELOW_M) / 2
    inside = (np.abs(local) <= (boxes.half + slack)[:, None]).all(axis=2)
    volume = boxes.half.prod(axis=1)
    if floor.sum() > 1:
        on_floor = on_floor & (np.abs(local) <= boxes.half[:, None])[:, :, [0, 2]].all(axis=2)
    contained = inside & vessel[:, None] & (volume[None, :] < volume[:, None])
    return np.where(floor[:, None], on_floor & ~contained.any(axis=0), contained | (inside & (foot[:, 1] >= floor_y + ABOVE_M)))
