"""Triangle meshes: of one instance in the frame of its box, and of many instances in the world.

World frame as in `floorplan`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ovman_engine import shapes
from ovman_engine.paint import materials as paint
from ovman_engine.picture import corners
from ovman_engine.plan.floorplan import Box


@dataclass(frozen=True)
class TriangleMesh:
    """A triangle mesh with V vertices, T triangles, P parts and N names.

    All is in world coordinates, metres. Triangles wind as their parts do; shading uses the visible side.
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
    """(T,) int32: axis 0, 1 or 2 of the part that the triangle faces; its texture lies on the other two"""
    frames: np.ndarray
    """(P, 3, 4) float32: world point -> point in the frame of the part, metres"""
    extents: np.ndarray
    """(P, 3) float32: half extents of the part, metres"""
    names: tuple[str, ...]
    """objectIds of the floor plan in its order, then the structures of the room"""
    materials: tuple[paint.Material, ...]

    @cached_property
    def spans(self) -> Mapping[int, tuple[slice, slice]]:
        """Instance -> slices of its vertices and of its triangles."""
        starts = np.flatnonzero(np.diff(self.instance, prepend=-1))
        ends = np.append(starts[1:], len(self.instance))[: len(starts)]
        spans = {}
        for start, end in zip(starts, ends, strict=True):
            used = self.triangles[start:end]
            spans[int(self.instance[start])] = (slice(int(used.min()), int(used.max()) + 1), slice(int(start), int(end)))
        return spans


@dataclass(frozen=True)
class InstanceMesh:
    """The mesh of one instance in the frame of its box; materials and parts count from zero."""

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
    """Palette slots of `materials`"""

    @property
    def radius_m(self) -> float:
        """Radius, metres, of the sphere around the centre of the box that contains all vertices and the boxes of all parts."""
        parts = np.linalg.norm(self.frames[:, :, 3], axis=1) + np.linalg.norm(self.extents, axis=1)
        return float(max(np.linalg.norm(self.vertices, axis=1).max(), parts.max()))


def instance_mesh(parts: Sequence[shapes.Part], palette: Mapping[str, paint.Material]) -> InstanceMesh | None:
    """Return the mesh of the drawn `parts` of one instance, with one material for each slot of `palette` in use.

    None if it has no triangles.
    """
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
    return InstanceMesh(
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


def assembled(
    items: Iterable[tuple[int, InstanceMesh, Box]],
    names: tuple[str, ...],
    materials: tuple[paint.Material, ...],
    offsets: Mapping[int, int],
) -> TriangleMesh:
    """Return the meshes of the instances at the poses of their boxes, one after the other.

    `offsets`: instance -> index of its first material.
    """
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
        return TriangleMesh(*empty, np.zeros((0, 3, 4), np.float32), flat, names, materials)
    fields: list[Any] = [*(np.concatenate(column) for column in zip(*columns, strict=True)), names, materials]
    return TriangleMesh(*fields)


def without(mesh: TriangleMesh, instances: Iterable[int]) -> TriangleMesh:
    """Return the mesh with the vertices of some instances set to NaN, so that rays miss them; all indices stay valid."""
    vertices = mesh.vertices.copy()
    for instance in instances:
        if instance in mesh.spans:
            vertices[mesh.spans[instance][0]] = np.nan
    return replace(mesh, vertices=vertices)


def subset(mesh: TriangleMesh, triangles: np.ndarray) -> TriangleMesh:
    """Return the `triangles` (N,) of a mesh, by ascending number; names, materials, frames and extents are kept."""
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


def figure(parts: Sequence[shapes.Part], palette: Mapping[str, paint.Material], box: Box, beside: TriangleMesh) -> TriangleMesh:
    """Return a mesh of `parts` in the frame of `box` without an instance (-1).

    It has the names of the mesh `beside` it. Its materials, one for each slot in the order of the parts, are numbered after those
    of that mesh.
    """
    local = instance_mesh(parts, palette)
    return assembled([] if local is None else [(-1, local, box)], beside.names, beside.materials, {-1: len(beside.materials)})


def joined(first: TriangleMesh, second: TriangleMesh) -> TriangleMesh:
    """Both meshes of one plan as one; triangles of `second` come last, and its names count."""
    vertex, part = np.int32(len(first.vertices)), np.int32(len(first.frames))
    return TriangleMesh(
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
