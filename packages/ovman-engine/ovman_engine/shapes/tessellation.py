"""Triangles of a part. Every mesh is closed and wound outwards: cross(b - a, c - a) points out, computed on the coordinates."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ovman_engine.shapes.part import Part, cross

Mesh = tuple[np.ndarray, np.ndarray]

_AXIS_M = 1e-9
MESHES_KEPT = 1000
"""Forms of parts that are kept: those of one scene."""
_made: dict[tuple[object, ...], Mesh] = {}


def _facets(part: Part) -> int:
    """Facets around: finer for what is larger, so that no outline shows corners from a metre away."""
    if part.segments:
        return part.segments
    width = float(max(part.size[0], part.size[2]))
    return int(np.clip(12 + 44 * width, 16, 32)) // 4 * 4


def revolved(profile: np.ndarray, segments: int) -> Mesh:
    """Surface of `profile` (N, 2) = (radius, y) turned about y. Closed if the profile ends on the axis or where it began."""
    angle = 2 * np.pi * np.arange(segments) / segments
    closed = bool(np.allclose(profile[0], profile[-1])) and profile[0, 0] > _AXIS_M
    radius, height = (profile[:-1] if closed else profile).T
    around = radius > _AXIS_M
    rings = np.empty((len(radius), segments, 3))
    rings[..., 0] = np.where(around, radius, 0.0)[:, None] * np.cos(angle)
    rings[..., 1] = height[:, None]
    rings[..., 2] = np.where(around, radius, 0.0)[:, None] * np.sin(angle)
    here = around[:, None] | (np.arange(segments) == 0)  # a point on the axis stands for its ring
    start = np.cumsum([0, *np.where(around, segments, 1)])[:-1]
    rows = start[:, None] + np.where(around[:, None], np.arange(segments), 0)
    if closed:
        rows, around = np.concatenate([rows, rows[:1]]), np.append(around, around[0])
    on = np.concatenate([rows[:, 1:], rows[:, :1]], axis=1)
    a, b, c, d = rows[:-1], on[:-1], rows[1:], on[1:]
    faces = np.stack([np.stack([a, d, b], axis=2), np.stack([a, c, d], axis=2)], axis=1)
    kept = np.stack([around[:-1], around[1:]], axis=1)
    return rings[here], faces[kept].reshape(-1, 3).astype(np.int32)


def _half_circle(count: int) -> np.ndarray:
    angle = np.linspace(-np.pi / 2, np.pi / 2, count)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1) / 2
    points[[0, -1], 0] = 0.0
    return points


@lru_cache(maxsize=512)
def _unit(kind: str, ratio: float, segments: int, crown: float = 0.0) -> Mesh:
    """Return a revolved form in the unit cube centred on the origin."""
    if kind == "cylinder":
        profile = np.array([(0, -0.5), (0.5, -0.5), (0.5, 0.5), (0, 0.5)])
    elif kind == "frustum":
        bottom, top = (0.5, 0.5 * ratio) if ratio <= 1 else (0.5 / ratio, 0.5)
        profile = np.array([(0, -0.5), (bottom, -0.5), (top, 0.5), (0, 0.5)])
        if top <= _AXIS_M:
            profile = profile[:3]
    elif kind == "torus":
        turn = np.linspace(-np.pi, np.pi, 9)
        tube = ratio / 4
        profile = np.stack([0.5 - tube + tube * np.cos(turn), 0.5 * np.sin(turn)], axis=1)
        profile[-1] = profile[0]
    else:
        profile = _half_circle(segments // 2 + 1)
    vertices, faces = revolved(profile, segments)
    if kind == "cushion":
        radius = np.hypot(vertices[:, 0], vertices[:, 2])
        flat = np.where(radius > _AXIS_M, radius, 1.0)
        about = vertices[:, [0, 2]] / flat[:, None]
        crown = crown or ratio
        soft = np.sign(about) * np.abs(about) ** ratio * ((2 * radius) ** crown)[:, None] / 2
        height = np.sign(vertices[:, 1]) * np.abs(2 * vertices[:, 1]) ** crown / 2
        vertices = np.stack([soft[:, 0], height, soft[:, 1]], axis=1)
    extent = vertices.max(axis=0) - vertices.min(axis=0)
    vertices = (vertices - (vertices.max(axis=0) + vertices.min(axis=0)) / 2) / extent
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces


_BOX_FACES = np.array(
    [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
        (1, 5, 7),
        (1, 7, 3),
    ],
    dtype=np.int32,
)
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@lru_cache(maxsize=1)
def _bevelled_faces() -> np.ndarray:
    """Faces over the 24 vertices corner * 3 + axis: the vertex of `corner` on the face along `axis`. Wound outwards."""
    faces = []
    signs = np.sign(_CORNERS)

    def corner(sign: np.ndarray) -> int:
        return int((sign > 0) @ [4, 2, 1])

    def add(loop: list[int], outwards: np.ndarray, places: np.ndarray) -> None:
        for i in range(1, len(loop) - 1):
            a, b, c = loop[0], loop[i], loop[i + 1]
            normal = np.cross(places[b] - places[a], places[c] - places[a])
            faces.append((a, b, c) if normal @ outwards > 0 else (a, c, b))

    places = np.array([signs[c] * np.where(np.arange(3) == a, 1.0, 0.8) for c in range(8) for a in range(3)])
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for s in (-1, 1):
            outwards = np.zeros(3)
            outwards[axis] = s
            loop = []
            for su, sv in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                sign = np.zeros(3)
                sign[axis], sign[u], sign[v] = s, su, sv
                loop.append(corner(sign) * 3 + axis)
            add(loop, outwards, places)
        for su in (-1, 1):
            for sv in (-1, 1):
                low, high = np.zeros(3), np.zeros(3)
                low[[axis, u, v]], high[[axis, u, v]] = (-1, su, sv), (1, su, sv)
                a, b = corner(low), corner(high)
                add([a * 3 + u, b * 3 + u, b * 3 + v, a * 3 + v], low + high, places)
    for c in range(8):
        add([c * 3, c * 3 + 1, c * 3 + 2], signs[c], places)
    return np.array(faces, dtype=np.int32)


def _box(size: np.ndarray, bevel: float) -> Mesh:
    cut = min(bevel, 0.45 * float(size.min()))
    if cut <= 1e-5:
        return _CORNERS * size, _BOX_FACES
    inset = np.repeat(_CORNERS * size - np.sign(_CORNERS) * cut, 3, axis=0)
    axis = np.tile(np.arange(3), 8)
    inset[np.arange(24), axis] += np.repeat(np.sign(_CORNERS), 3, axis=0)[np.arange(24), axis] * cut
    return inset, _bevelled_faces()


def _prism(outline: np.ndarray, depth: float) -> Mesh:
    count = len(outline)
    vertices = np.concatenate([np.column_stack([outline, np.full(count, z)]) for z in (-depth / 2, depth / 2)])
    i = np.arange(1, count - 1)
    k = np.arange(count)
    n = (k + 1) % count
    zero = np.zeros_like(i)
    faces = np.concatenate(
        [
            np.stack([zero, i + 1, i], axis=1),
            np.stack([zero + count, i + count, i + 1 + count], axis=1),
            np.stack([k, n, n + count], axis=1),
            np.stack([k, n + count, k + count], axis=1),
        ]
    )
    return vertices, faces.astype(np.int32)


def _swept(path: np.ndarray, radius: np.ndarray, sides: int) -> Mesh:
    """Return a round skin about `path` (N, 3) with `radius` (N,), closed by flat ends.

    The frame is carried along without twist.
    """
    steps = np.diff(path, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    tangent = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = cross(tangent[0], np.array([0.0, 0.0, 1.0] if abs(tangent[0, 2]) < 0.9 else [1.0, 0.0, 0.0]))
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = []
    for point, along, r in zip(path, tangent, radius, strict=True):
        side = side - along * (side @ along)
        side /= np.linalg.norm(side)
        other = cross(along, side)
        rings.append(point + r * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other))
    count = len(path)
    vertices = np.concatenate([*rings, path[:1], path[-1:]])
    faces = []
    j = np.arange(sides)
    n = (j + 1) % sides
    for i in range(count - 1):
        a, b = i * sides, (i + 1) * sides
        faces += [np.stack([a + j, a + n, b + n], axis=1), np.stack([a + j, b + n, b + j], axis=1)]
    last = (count - 1) * sides
    faces.append(np.stack([np.full(sides, count * sides), n, j], axis=1))
    faces.append(np.stack([np.full(sides, count * sides + 1), last + j, last + n], axis=1))
    return vertices, np.concatenate(faces).astype(np.int32)


@lru_cache(maxsize=64)
def _unit_leaf(sections: int) -> Mesh:
    """Return a blade from y 0 to 1, half width 0.5, curling to z 1 at its tip, with a low ridge on its upper side."""
    t = np.linspace(0, 1, sections + 2)
    width = np.sin(np.pi * t**0.8) ** 0.8 / 2
    left, right, ridge = [], [], []
    for at, half in zip(t[1:-1], width[1:-1], strict=True):
        curl = at**2
        left.append((-half, at, curl))
        right.append((half, at, curl))
        ridge.append((0.0, at, curl - 0.16 * half - 0.02))
    vertices = np.array([p for triple in zip(left, right, ridge, strict=True) for p in triple] + [(0, 0, 0), (0, 1, 1)])
    vertices[:, 0] /= np.abs(vertices[:, 0]).max() * 2
    base, tip = len(vertices) - 2, len(vertices) - 1
    corners = []
    for i in range(sections - 1):
        a, b = 3 * i, 3 * (i + 1)
        for p, q in ((0, 1), (1, 2), (2, 0)):
            corners += [(a + p, a + q, b + q), (a + p, b + q, b + p)]
    last = 3 * (sections - 1)
    for p, q in ((0, 1), (1, 2), (2, 0)):
        corners += [(base, q, p), (tip, last + p, last + q)]
    faces = np.array(corners, dtype=np.int32)
    if _volume(vertices, faces) < 0:
        faces = faces[:, ::-1]
    return vertices, faces


def _volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def local_mesh(part: Part) -> Mesh:
    """Mesh of `part` in its own axes, origin at its centre: vertices (V, 3) float64 metres, triangles (T, 3) int32.

    Shared by all parts of the form, which come in numbers and are asked for while they are fitted and when they are drawn: not to
    be written to.
    """
    points = None if part.points is None else part.points.tobytes()
    form = (part.kind, part.size.tobytes(), part.bevel, part.ratio, part.crown, points, part.segments)
    found = _made.get(form)
    if found is None:
        while len(_made) >= MESHES_KEPT:
            del _made[next(iter(_made))]
        found = _made[form] = _made_of(part)
    return found


def _made_of(part: Part) -> Mesh:
    if part.kind == "box":
        return _box(part.size, part.bevel)
    if part.kind == "prism":
        return _prism(part.outline, float(part.size[2]))
    if part.kind == "tube":
        return _swept(part.outline, np.full(len(part.outline), part.ratio), part.segments or 8)
    if part.kind == "leaf":
        vertices, faces = _unit_leaf(part.segments or 4)
        return vertices * part.size, faces
    if part.kind == "lathe":
        vertices, faces = revolved(part.outline, _facets(part))
        extent = 2 * part.outline[:, 0].max()
        return vertices * [part.size[0] / extent, 1.0, part.size[2] / extent], faces
    if part.kind == "capsule":
        radius = min(float(part.size[0]), float(part.size[2]), float(part.size[1])) / 2
        profile = _half_circle(9) * 2 * radius
        profile[:, 1] += np.sign(np.arange(9) - 4) * (part.size[1] / 2 - radius)
        profile = np.insert(profile, 4, [radius, -(part.size[1] / 2 - radius)], axis=0)
        profile[5] = (radius, part.size[1] / 2 - radius)
        if part.size[1] / 2 - radius < 1e-6:
            profile = np.delete(profile, 4, axis=0)
        vertices, faces = revolved(profile, _facets(part))
        return vertices * [part.size[0] / 2 / radius, 1.0, part.size[2] / 2 / radius], faces
    vertices, faces = _unit(part.kind, float(part.ratio), _facets(part), float(part.crown))
    return vertices * part.size, faces


def mesh(part: Part) -> Mesh:
    """Vertices (V, 3) float64 in metres and triangles (T, 3) int32 of `part`, in the oriented box's frame, wound outwards."""
    vertices, faces = local_mesh(part)
    return vertices @ part.rotation.T + part.centre, faces
