"""A world as AI2-THOR's metadata. What is untouched is reported in the very numbers of its record."""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman.engine.event import vector
from ovman.engine.floorplan import euler_degrees
from ovman.engine.settings import Settings
from ovman.engine.visibility import Eye, Sight
from ovman.engine.world import Body, World

MOTION = 1e-4
"""v**2 + w**2 (m/s and rad/s) above which a body counts as moving."""
ABOVE_M, BELOW_M = 0.05, 0.02
"""A thing is on or in a receptacle if the middle of its underside lies in the receptacle's box, or this far above or below."""


class SceneMetadata:
    """The metadata of one world, kept up to date: records are remade only for bodies that changed, sight only when somebody
    or something moved."""

    def __init__(self, world: World) -> None:
        self._world = world
        low, high = world.bounds()
        self._bounds = {**_aligned((low + high) / 2, high - low), "cornerPoints": _corners(low, high)}
        self._version: tuple[int, bool] | None = None
        self._seen_from: tuple[Any, ...] | None = None
        self._records: dict[str, dict[str, Any]] = {}
        self._made_of: dict[str, tuple[Any, ...]] = {}
        self._rearranged = False

    def state(self, settings: Settings, aspect: float) -> dict[str, Any]:
        """The part of an event's metadata that tells of the world, its agent and its objects. The lists and dicts are reused:
        to be written out before the world goes on."""
        agent = self._world.agent
        objects = self._objects(settings, aspect)
        if settings.shown is not None:
            objects = [o for o in objects if o["objectId"] in settings.shown]
        return {
            "objects": objects,
            "isSceneAtRest": bool(self._world.at_rest),
            "agent": {
                "name": "agent",
                "position": vector(*agent.position),
                "rotation": vector(0.0, agent.yaw_deg, 0.0),
                "cameraHorizon": float(agent.horizon_deg),
                "isStanding": bool(agent.standing),
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
        eye = Eye(agent.position, agent.camera, agent.yaw_deg, agent.horizon_deg, settings.field_of_view_deg, aspect)
        seen_from = (*agent.position, agent.yaw_deg, agent.horizon_deg, agent.standing, settings, aspect)
        if self._seen_from != seen_from:
            self._look(eye, settings.visibility_m, settings.shown)
            self._seen_from = seen_from
        return self._list

    def _refresh(self) -> None:
        bodies = [b for b in self._world.bodies.values() if not b.removed]
        for body in bodies:
            made_of = (body.object_id, body.name, body.active, body.pose.position, body.pose.rotation)
            old = self._made_of.get(body.object_id)
            if old is None or any(a is not b for a, b in zip(made_of, old, strict=True)):
                self._records[body.object_id] = _record(body)
                self._made_of[body.object_id] = made_of
            self._records[body.object_id]["isMoving"] = bool(body.velocity @ body.velocity > MOTION)
        self._list = [self._records[b.object_id] for b in bodies]
        self._positions = np.array([b.pose.position for b in bodies]).reshape(-1, 3)
        self._sight = Sight([b.box for b in bodies], [b.active for b in bodies], [b.obj.type != "Floor" for b in bodies])
        self._keep_receptacles(bodies)

    def _look(self, eye: Eye, distance_m: float, shown: frozenset[str] | None) -> None:
        asked = np.array([shown is None or record["objectId"] in shown for record in self._list], dtype=bool)
        visible = self._sight.visible(eye, distance_m, asked).tolist()
        distances = np.linalg.norm(self._positions - eye.agent, axis=1).tolist()
        for record, distance, seen in zip(self._list, distances, visible, strict=True):
            record["distance"] = distance
            record["visible"] = record["isInteractable"] = seen

    def _keep_receptacles(self, bodies: list[Body]) -> None:
        """Who is on or in what: as recorded between things that are where they were, by their boxes otherwise."""
        there = {b.object_id: b for b in bodies if b.active}
        changed = {name for name, b in there.items() if not b.untouched or name != b.obj.object_id}
        if changed or len(there) < len(self._world.plan.objects):
            self._rearranged = True
        elif not self._rearranged:
            return
        still = there.keys() - changed
        holders = {name: b for name, b in there.items() if b.obj.record["receptacle"]}
        parents: dict[str, list[str]] = {}
        children: dict[str, list[str]] = {b.object_id: [] for b in bodies}
        for name, holder in holders.items():
            if name in still:
                children[name] = [c for c in holder.obj.record["receptacleObjectIds"] or () if c in still]
        for body in bodies:
            name = body.object_id
            parents[name] = [p for p in body.obj.parents if p in still] if name in still else []
            for other in holders if name in changed else holders.keys() & changed if name in still else ():
                if other != name and _holds(holders[other], body, self._world.plan.floor_y):
                    parents[name].append(other)
                    children[other].append(name)
        for body in bodies:
            record = self._records[body.object_id]
            record["parentReceptacles"] = parents[body.object_id] or None
            record["receptacleObjectIds"] = children[body.object_id] if body.obj.record["receptacle"] else None


def _record(body: Body) -> dict[str, Any]:
    """The 42 keys of an object, those that depend on the agent as recorded."""
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


def _aligned(centre: np.ndarray, size: np.ndarray) -> dict[str, Any]:
    return {"center": vector(*centre), "size": vector(*size)}


def _corners(low: np.ndarray, high: np.ndarray) -> list[list[float]]:
    """In AI2-THOR's order."""
    return [[float(x), float(y), float(z)] for x in (high[0], low[0]) for y in (high[1], low[1]) for z in (high[2], low[2])]


def _holds(receptacle: Body, body: Body, floor_y: float) -> bool:
    low, high = body.box.bounds()
    foot = np.array([(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2])
    on_floor = foot[1] < floor_y + ABOVE_M
    if receptacle.obj.type == "Floor":
        return bool(on_floor)
    box = receptacle.box
    local = np.abs(box.rotation.T @ (foot + [0.0, (BELOW_M - ABOVE_M) / 2, 0.0] - box.centre))
    slack = np.abs(box.rotation.T @ [0.0, (ABOVE_M + BELOW_M) / 2, 0.0])
    return bool((local <= box.half + slack).all()) and not on_floor
