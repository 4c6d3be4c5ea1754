"""Triangles of a world, each with its instance, its material and the frame that its texture hangs in.

World frame as in `floorplan`. An object's mesh is made once per floor plan, in the frame of the object's oriented box, and only
carried along when the object moves: normals and texture frames turn with it, so textures stick to things.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ovman_engine import shapes
from ovman_engine.paint import materials as paint
from ovman_engine.picture import corners
from ovman_engine.plan.floorplan import Box, FloorPlan

SAME = 1e-6
"""Metres, and entries of a rotation matrix, within which two poses are one."""
PLANS_KEPT = 3
"""Floor plans whose meshes are kept: a session resets the same few scenes again and again."""


@dataclass(frozen=True)
class SceneMesh:
    """A triangle soup. V vertices, T triangles, P parts, N names.

    Frames: everything in world coordinates, metres. Triangles wind as their parts do; shading uses the side that is seen.
    """

    vertices: np.ndarray
    """(V, 3) float32"""
    triangles: np.ndarray
    """(T, 3) int32 into vertices"""
    normals: np.ndarray
    """(T, 3, 3) float32 unit normal at each corner of each triangle"""
    instance: np.ndarray
    """(T,) int32 into names"""
    material: np.ndarray
    """(T,) int32 into materials"""
    part: np.ndarray
    """(T,) int32 into frames and extents"""
    axis: np.ndarray
    """(T,) int32: axis 0, 1, 2 of the part that the triangle faces; its texture is laid on the other two"""
    frames: np.ndarray
    """(P, 3, 4) float32: world point -> point in the frame of the part, metres"""
    extents: np.ndarray
    """(P, 3) float32: half extents of the part, metres"""
    names: tuple[str, ...]
    """objectIds of the floor plan in its order, then the structures of the room"""
    materials: tuple[paint.Material, ...]

    @cached_property
    def spans(self) -> Mapping[int, tuple[slice, slice]]:
        """Instance -> (its vertices, its triangles); both are consecutive."""
        starts = np.flatnonzero(np.diff(self.instance, prepend=-1))
        ends = np.append(starts[1:], len(self.instance))[: len(starts)]
        spans = {}
        for start, end in zip(starts, ends, strict=True):
            used = self.triangles[start:end]
            spans[int(self.instance[start])] = (slice(int(used.min()), int(used.max()) + 1), slice(int(start), int(end)))
        return spans


@dataclass(frozen=True)
class _Local:
    """Mesh of one instance in the frame of its box; material and part count from zero within the instance's own lists."""

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    material: np.ndarray
    part: np.ndarray
    axis: np.ndarray
    frames: np.ndarray
    extents: np.ndarray
    materials: tuple[paint.Material, ...]
    slots: tuple[str, ...]
    """Slots of the palette that `materials` are"""

    @property
    def radius_m(self) -> float:
        """Of the sphere around the centre of the instance's box that its vertices and the boxes of its parts lie in."""
        parts = np.linalg.norm(self.frames[:, :, 3], axis=1) + np.linalg.norm(self.extents, axis=1)
        return float(max(np.linalg.norm(self.vertices, axis=1).max(), parts.max()))


def _local(parts: Sequence[shapes.Part], palette: Mapping[str, paint.Material]) -> _Local | None:
    parts = [part for part in parts if part.drawn]
    slots = list(dict.fromkeys(part.slot for part in parts))
    meshes = [shapes.mesh(part) for part in parts]
    counts = np.array([len(triangles) for _, triangles in meshes], dtype=int)
    if not counts.sum():
        return None
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes])
    triangles = np.concatenate([triangles + start for (_, triangles), start in zip(meshes, first, strict=False)], dtype=np.int32)
    part = np.repeat(np.arange(len(parts), dtype=np.int32), counts)
    slot = np.array([slots.index(p.slot) for p in parts], dtype=np.int32)
    turns, centres = np.array([p.rotation for p in parts], dtype=float), np.array([p.centre for p in parts], dtype=float)
    normals, axis = corners.of_parts(vertices, triangles, part, turns)
    back = turns.transpose(0, 2, 1)
    return _Local(
        vertices,
        triangles,
        normals.astype(np.float32),
        slot[part],
        part,
        axis,
        np.concatenate([back, -(back @ centres[:, :, None])], axis=2),
        np.array([p.size for p in parts], dtype=float) / 2,
        tuple(palette[slot] for slot in slots),
        tuple(slots),
    )


def _joined(
    items: Iterable[tuple[int, _Local, Box]],
    names: tuple[str, ...],
    materials: tuple[paint.Material, ...],
    offsets: Mapping[int, int],
) -> SceneMesh:
    """The instances' meshes, posed by their boxes, one after the other. `offsets`: instance -> index of its first material."""
    columns: list[tuple[np.ndarray, ...]] = []
    vertex = part = 0
    for instance, local, box in items:
        turn = box.rotation
        frames = np.empty_like(local.frames)
        frames[:, :, :3] = local.frames[:, :, :3] @ turn.T
        frames[:, :, 3] = local.frames[:, :, 3] - frames[:, :, :3] @ box.centre
        columns.append(
            (
                (local.vertices @ turn.T + box.centre).astype(np.float32),
                local.triangles + np.int32(vertex),
                local.normals @ turn.T.astype(np.float32),
                np.full(len(local.triangles), instance, dtype=np.int32),
                local.material + np.int32(offsets[instance]),
                local.part + np.int32(part),
                local.axis,
                frames.astype(np.float32),
                local.extents.astype(np.float32),
            )
        )
        vertex += len(local.vertices)
        part += len(local.frames)
    if not columns:
        none = np.zeros(0, dtype=np.int32)
        flat = np.zeros((0, 3), dtype=np.float32)
        empty = (flat, np.zeros((0, 3), np.int32), np.zeros((0, 3, 3), np.float32), none, none, none, none)
        return SceneMesh(*empty, np.zeros((0, 3, 4), np.float32), flat, names, materials)
    return SceneMesh(*(np.concatenate(column) for column in zip(*columns, strict=True)), names, materials)


_WORLD_BOX = Box(np.zeros(3), np.ones(3), np.eye(3))
"""Structures are given in the world frame."""


@dataclass(frozen=True)
class Placement:
    """An object drawn at a box of its own. `source`: the object of the plan whose shape and materials it has (itself or, for a
    copy, the original)."""

    object_id: str
    source: str
    box: Box


def structures(plan: FloorPlan, room) -> tuple[tuple[str, tuple[shapes.Part, ...], Mapping[str, paint.Material]], ...]:
    """Names, parts in the world frame and palettes of what is seen of a scene but is none of its objects: the room and the
    bodies of its counters."""
    below = []
    for counter, parts in shapes.bodies(plan):
        x, y, z = (float(v) for v in counter.box.centre)
        below.append((f"base|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}", parts, paint.palette(counter, plan)))
    return (*room.parts(), *below)


class PlanMeshes:
    """The meshes of all that a floor plan and its room hold, made once.

    `untouched` is the scene as the floor plan records it; `posed` gives any of its objects at other poses.
    """

    def __init__(self, plan: FloorPlan, room) -> None:
        self.plan = plan
        fixtures = structures(plan, room)
        self.names = tuple(o.object_id for o in plan.objects) + tuple(name for name, _, _ in fixtures)
        self._index = {name: i for i, name in enumerate(self.names)}
        locals_: dict[int, _Local] = {}
        for obj in plan.objects:
            made = _local(shapes.drawn(obj, plan), paint.palette(obj, plan))
            if made is not None:
                locals_[self._index[obj.object_id]] = made
        for name, parts, palette in fixtures:
            made = _local(parts, palette)
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

    def _join(self, poses: Iterable[tuple[int, Box]]) -> SceneMesh:
        return _joined(((i, self._locals[i], box) for i, box in poses), self.names, self.materials, self._offsets)

    def repainted(self, palettes: Mapping[str, Mapping[str, paint.Material]]) -> tuple[paint.Material, ...]:
        """`materials` with those of other `palettes` by the names of instances, in the same order."""
        return tuple(palettes[self.names[i]][slot] for i, made in self._locals.items() for slot in made.slots)

    def index(self, object_id: str) -> int:
        """Index of an instance in `names`. KeyError if there is none."""
        return self._index[object_id]

    def radius_m(self, object_id: str) -> float:
        """How far from the centre of its box an object of the plan and the boxes of its parts reach, metres, whichever way it is
        turned; 0 for one of which nothing is drawn. KeyError if there is none."""
        if object_id not in self._radius_m:
            local = self._locals.get(self._index[object_id])
            self._radius_m[object_id] = 0.0 if local is None else local.radius_m
        return self._radius_m[object_id]

    def posed(self, placements: Sequence[Placement]) -> SceneMesh:
        """Mesh of some objects, each at its placement. Objects that the plan does not name (copies) come last."""
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
        return _joined(items, self.names + copies, self.materials, offsets)


_plans: OrderedDict[int, tuple[FloorPlan, PlanMeshes]] = OrderedDict()


def of_plan(plan: FloorPlan, room) -> PlanMeshes:
    """`PlanMeshes` of a floor plan, remembered for the last few plans. The room must be the plan's own (`room_of(plan)`)."""
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
    """How a world differs from its floor plan, for the eye."""

    displaced: frozenset[str]
    """Objects of the plan that are not drawn where it has them"""
    placements: tuple[Placement, ...]
    """What is drawn elsewhere"""


def changes(world) -> Changes:
    """What differs between a world and its floor plan: a function of the current state, not of how it came about.

    An object that is back to within `SAME` is where the plan has it, so that moving it there and back restores every pixel.
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


def without(mesh: SceneMesh, instances: Iterable[int]) -> SceneMesh:
    """The mesh with the vertices of some instances taken out of the world (NaN), so that rays pass; all indices stay."""
    vertices = mesh.vertices.copy()
    for instance in instances:
        if instance in mesh.spans:
            vertices[mesh.spans[instance][0]] = np.nan
    return replace(mesh, vertices=vertices)


def subset(mesh: SceneMesh, triangles: np.ndarray) -> SceneMesh:
    """The `triangles` (N,) of a mesh, given by number in ascending order; names, materials, frames and extents are all kept."""
    used, corners = np.unique(mesh.triangles[triangles], return_inverse=True)
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        triangles=corners.reshape(-1, 3).astype(np.int32),
        normals=mesh.normals[triangles],
        instance=mesh.instance[triangles],
        material=mesh.material[triangles],
        part=mesh.part[triangles],
        axis=mesh.axis[triangles],
    )


def figure(parts: Sequence[shapes.Part], palette: Mapping[str, paint.Material], box: Box, beside: SceneMesh) -> SceneMesh:
    """A mesh of `parts` in the frame of `box` that is no instance: -1. It has the names of the mesh `beside` it. Its materials,
    one for each slot in the order of the parts, are numbered after those of that mesh."""
    local = _local(parts, palette)
    return _joined([(-1, local, box)], beside.names, beside.materials, {-1: len(beside.materials)})


def joined(first: SceneMesh, second: SceneMesh) -> SceneMesh:
    """Both meshes of one plan as one; triangles of `second` come after all of `first`, and its names count."""
    vertex, part = np.int32(len(first.vertices)), np.int32(len(first.frames))
    return SceneMesh(
        np.concatenate([first.vertices, second.vertices]),
        np.concatenate([first.triangles, second.triangles + vertex]),
        np.concatenate([first.normals, second.normals]),
        np.concatenate([first.instance, second.instance]),
        np.concatenate([first.material, second.material]),
        np.concatenate([first.part, second.part + part]),
        np.concatenate([first.axis, second.axis]),
        np.concatenate([first.frames, second.frames]),
        np.concatenate([first.extents, second.extents]),
        second.names,
        first.materials,
    )


def build(world) -> SceneMesh:
    """Everything that a world draws now, as one mesh: what is where the plan has it first, then what was displaced."""
    meshes = of_plan(world.plan, world.room)
    now = changes(world)
    fixed = without(meshes.untouched, [meshes.index(o) for o in now.displaced])
    return joined(fixed, meshes.posed(now.placements))
