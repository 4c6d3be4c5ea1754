"""The triangles of a world, with instances, materials and texture frames.

World frame as in `floorplan`. The mesh of an object is built once for each floor plan, in the frame of the object's oriented box,
and transformed when the object moves: normals and texture frames turn with it, so textures do not slide.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ovman_engine import kernels, shapes
from ovman_engine.paint import materials as paint
from ovman_engine.picture import painter
from ovman_engine.picture.triangle_mesh import InstanceMesh, TriangleMesh, assembled, instance_mesh, joined, without
from ovman_engine.plan.floorplan import Box, FloorPlan

SAME = 1e-6
"""Tolerance of equal poses: metres, and entries of a rotation matrix."""
PLANS_KEPT = 3
"""Floor plans whose meshes are cached: a session resets the same few scenes again and again."""


_WORLD_BOX = Box(np.zeros(3), np.ones(3), np.eye(3))
"""Box of a structure, whose parts are given in the world frame."""


@dataclass(frozen=True)
class Placement:
    """An object drawn at the pose of `box`.

    `source` is the object of the plan with its shape and materials: itself, or the original of a copy.
    """

    object_id: str
    source: str
    box: Box


def structures(plan: FloorPlan, room) -> tuple[tuple[str, tuple[shapes.Part, ...], Mapping[str, paint.Material]], ...]:
    """Return name, parts in the world frame and palette of everything visible that is no object.

    That is the room, and the bodies of counters.
    """
    below = []
    for counter, parts in shapes.bodies(plan):
        x, y, z = (float(v) for v in counter.box.centre)
        below.append((f"base|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}", parts, paint.palette(counter, plan)))
    return (*room.parts(), *below)


class PlanMeshes:
    """The meshes of a floor plan and its room.

    `untouched` is the scene as recorded; `posed` gives any of its objects at other poses.
    """

    def __init__(self, plan: FloorPlan, room) -> None:
        """Build the meshes of `plan` and of `room`, a room.Room."""
        self.plan = plan
        fixtures = structures(plan, room)
        self.names = tuple(o.object_id for o in plan.objects) + tuple(name for name, _, _ in fixtures)
        self._index = {name: i for i, name in enumerate(self.names)}
        locals_: dict[int, InstanceMesh] = {}
        for obj in plan.objects:
            made = instance_mesh(shapes.drawn(obj, plan), paint.palette(obj, plan))
            if made is not None:
                locals_[self._index[obj.object_id]] = made
        for name, parts, palette in fixtures:
            made = instance_mesh(parts, palette)
            if made is not None:
                locals_[self._index[name]] = made
        materials: list[paint.Material] = []
        self._offsets: dict[int, int] = {}
        for instance, made in locals_.items():
            self._offsets[instance] = len(materials)
            materials.extend(made.materials)
        self._locals = locals_
        self._radius_m: dict[str, float] = {}
        self.materials = tuple(materials)
        boxes = [o.box for o in plan.objects]
        self.untouched = self._join((i, boxes[i] if i < len(boxes) else _WORLD_BOX) for i in locals_)

    def _join(self, poses: Iterable[tuple[int, Box]]) -> TriangleMesh:
        return assembled(((i, self._locals[i], box) for i, box in poses), self.names, self.materials, self._offsets)

    def repainted(self, palettes: Mapping[str, Mapping[str, paint.Material]]) -> tuple[paint.Material, ...]:
        """`materials` with other `palettes`, by names of instances, in the same order."""
        return tuple(palettes[self.names[i]][slot] for i, made in self._locals.items() for slot in made.slots)

    def index(self, object_id: str) -> int:
        """Index of an instance in `names`. Raises KeyError for an unknown one."""
        return self._index[object_id]

    def radius_m(self, object_id: str) -> float:
        """Radius, metres, around the centre of its box that contains an object of the plan in any rotation.

        0 for an object without a mesh. Raises KeyError for an unknown object.
        """
        if object_id not in self._radius_m:
            local = self._locals.get(self._index[object_id])
            self._radius_m[object_id] = 0.0 if local is None else local.radius_m
        return self._radius_m[object_id]

    def hidden(self, displaced: frozenset[str]) -> np.ndarray:
        """(T,) bool: the triangles of `displaced` objects; (0,) for none."""
        if not displaced:
            return np.zeros(0, dtype=bool)
        mask = np.zeros(len(self.untouched.triangles), dtype=bool)
        for object_id in displaced:
            span = self.untouched.spans.get(self._index[object_id])
            if span is not None:
                mask[span[1]] = True
        return mask

    def posed(self, placements: Sequence[Placement]) -> TriangleMesh:
        """Mesh of objects at their placements. Copies, which the plan does not name, come last."""
        copies = tuple(p.object_id for p in placements if p.object_id not in self._index)
        index = self._index | {name: len(self.names) + i for i, name in enumerate(copies)}
        locals_, offsets, poses = {}, {}, []
        for placement in placements:
            source = self._index[placement.source]
            if source in self._locals:
                instance = index[placement.object_id]
                locals_[instance], offsets[instance] = self._locals[source], self._offsets[source]
                poses.append((instance, placement.box))
        items = ((i, locals_[i], box) for i, box in sorted(poses, key=lambda pose: pose[0]))
        return assembled(items, self.names + copies, self.materials, offsets)


_solids: WeakKeyDictionary[PlanMeshes, kernels.Solid] = WeakKeyDictionary()


def solid(meshes: PlanMeshes) -> kernels.Solid:
    """Return the untouched floor plan for the kernels, shared by the camera and the agent's visibility."""
    if meshes not in _solids:
        _solids[meshes] = painter.solid(meshes.untouched)
    return _solids[meshes]


_plans: OrderedDict[int, tuple[FloorPlan, PlanMeshes]] = OrderedDict()


def of_plan(plan: FloorPlan, room) -> PlanMeshes:
    """`PlanMeshes` of a floor plan, cached for the last few plans. The room must be the plan's own (`room_of(plan)`)."""
    found = _plans.get(id(plan))
    if found is None or found[0] is not plan:
        found = (plan, PlanMeshes(plan, room))
        _plans[id(plan)] = found
        while len(_plans) > PLANS_KEPT:
            _plans.popitem(last=False)
    _plans.move_to_end(id(plan))
    return found[1]


@dataclass(frozen=True)
class Changes:
    """The visible differences between a world and its floor plan."""

    displaced: frozenset[str]
    """Objects that are not drawn at their recorded poses"""
    placements: tuple[Placement, ...]
    """Objects that are drawn at other poses"""


def changes(world) -> Changes:
    """Return the differences between a world and its floor plan: a function of the current state, not of its history.

    An object within `SAME` of its recorded pose counts as undisplaced, so moving it there and back restores every pixel.
    """
    displaced, placements = {o.object_id for o in world.plan.objects}, []
    for object_id, body in world.bodies.items():
        if not body.present:
            continue
        obj = body.obj
        if object_id == obj.object_id and (body.untouched or _back(body)):
            displaced.remove(object_id)
        else:
            placements.append(Placement(object_id, obj.object_id, body.box))
    return Changes(frozenset(displaced), tuple(placements))


def _back(body) -> bool:
    pose, obj = body.pose, body.obj
    return np.abs(pose.position - obj.position).max() < SAME and np.abs(pose.rotation - obj.rotation).max() < SAME


def balls(meshes: PlanMeshes, now: Changes) -> np.ndarray:
    """(N, 4) float32: centre and radius, metres, of spheres around all that was displaced, where it was and where it is."""
    homes = [(meshes.plan[o].box.centre, meshes.radius_m(o)) for o in sorted(now.displaced)]
    homes += [(p.box.centre, meshes.radius_m(p.source)) for p in now.placements]
    return np.array([[*centre, radius] for centre, radius in homes], dtype=np.float32).reshape(-1, 4)


def build(world) -> TriangleMesh:
    """All that a world shows now, as one mesh: undisplaced objects first, then displaced ones."""
    meshes = of_plan(world.plan, world.room)
    now = changes(world)
    fixed = without(meshes.untouched, [meshes.index(o) for o in now.displaced])
    return joined(fixed, meshes.posed(now.placements))
