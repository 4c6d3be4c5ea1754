"""What the robot sees of a world: RGB, planar depth, instance ids and normals.

Source of the camera model: AI2-THOR 5.0.0 (contract, section 2). World frame: Unity's, left-handed, y up; yaw 0 looks along +z
and 90 along +x; horizon is positive downwards. Images have row 0 at the top, pixel centres at +0.5.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ovman.engine import lights, rays, scene_mesh, shading, textures

FIXED_KEPT = 4
"""Embree scenes kept per floor plan: one for each set of displaced objects seen lately."""
SAMPLES = np.array([[0.36, -0.22], [-0.36, 0.22]], dtype=np.float32)
"""Where a pixel on an edge is sampled besides its centre, pixels."""
SKY = np.array([0.55, 0.65, 0.75], dtype=np.float32)
"""Linear RGB where nothing is."""


@dataclass(frozen=True)
class View:
    """A camera. `orthographic_size`: half the height of the picture in metres; None for a perspective view. ValueError for a
    field of view outside (0, 180) degrees or a picture without pixels."""

    position: np.ndarray
    yaw_deg: float
    horizon_deg: float = 0.0
    fov_deg: float = 90.0
    """vertical"""
    width: int = 300
    height: int = 300
    near_m: float = 0.1
    far_m: float = 20.0
    orthographic_size: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.fov_deg < 180:
            raise ValueError(f"a field of view lies in (0, 180) degrees, not {self.fov_deg}")
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a picture of {self.width} x {self.height} pixels cannot be drawn")

    def axes(self) -> np.ndarray:
        """Rows right, up, forward: unit vectors (3, 3) in the world frame."""
        (sa, sp), (ca, cp) = (
            np.sin(np.radians([self.yaw_deg, self.horizon_deg])),
            np.cos(np.radians([self.yaw_deg, self.horizon_deg])),
        )
        return np.array([[ca, 0, -sa], [sa * sp, cp, ca * sp], [sa * cp, -sp, ca * cp]])


@dataclass(frozen=True)
class Frame:
    """What was asked for of one view; the rest is None. H x W pixels."""

    rgb: np.ndarray | None = None
    """(H, W, 3) uint8, sRGB"""
    depth: np.ndarray | None = None
    """(H, W) float32 metres along the view direction; far_m where nothing is"""
    ids: np.ndarray | None = None
    """(H, W) int32 into `Renderer.names`; -1 where nothing is"""
    normals: np.ndarray | None = None
    """(H, W, 3) float32 unit normals in the world frame, towards the viewer; 0 where nothing is"""


@dataclass(frozen=True)
class _Looks:
    """Materials as arrays, M of them."""

    colours: np.ndarray
    kinds: np.ndarray
    scales: np.ndarray
    seeds: np.ndarray
    glosses: np.ndarray
    emissions: np.ndarray

    @staticmethod
    def of(materials) -> _Looks:
        return _Looks(
            np.array([m.colour for m in materials], dtype=np.float32).reshape(-1, 3),
            np.array([textures.KINDS.index(m.texture) for m in materials], dtype=np.int32),
            np.array([m.scale_m for m in materials], dtype=np.float32),
            np.array([m.seed & 0x7FFFFFFF for m in materials], dtype=np.int64),
            np.array([m.gloss for m in materials], dtype=np.float32),
            np.array([m.emission for m in materials], dtype=np.float32),
        )


class _Plan:
    """What renderers of one floor plan share: meshes, materials, and the Embree scenes of what stays where it was."""

    def __init__(self, world) -> None:
        self.meshes = scene_mesh.of_plan(world.plan, world.room)
        self.looks = _Looks.of(self.meshes.materials)
        self._scenes: OrderedDict[frozenset[str], object] = OrderedDict()
        vertices = self.meshes.untouched.vertices
        self.low, self.high = vertices.min(axis=0).astype(float), vertices.max(axis=0).astype(float)

    def fixed(self, displaced: frozenset[str]):
        """Embree scene of all that the plan has, without `displaced`."""
        if displaced not in self._scenes:
            mesh = self.meshes.untouched
            if displaced:
                mesh = scene_mesh.without(mesh, [self.meshes.index(o) for o in displaced])
            self._scenes[displaced] = rays.committed(mesh)
            while len(self._scenes) > FIXED_KEPT:
                self._scenes.popitem(last=False)
        self._scenes.move_to_end(displaced)
        return self._scenes[displaced]


_plans: OrderedDict[int, _Plan] = OrderedDict()


def _plan(world) -> _Plan:
    found = _plans.get(id(world.plan))
    if found is None or found.meshes.plan is not world.plan:
        found = _plans[id(world.plan)] = _Plan(world)
        while len(_plans) > scene_mesh.PLANS_KEPT:
            _plans.popitem(last=False)
    _plans.move_to_end(id(world.plan))
    return found


@lru_cache(maxsize=8)
def _centres(width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows (H W,) float32 of all pixel centres."""
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32) + np.float32(0.5)
    return columns.ravel(), rows.ravel()


@dataclass
class _Hits:
    """N image points and what their rays hit."""

    columns: np.ndarray
    rows: np.ndarray
    origins: np.ndarray
    rays: np.ndarray
    prim: np.ndarray
    distance: np.ndarray
    u: np.ndarray
    v: np.ndarray


class Renderer:
    """Draws a world. Follows its changes by `world.version`; draws nothing until a frame is asked for."""

    def __init__(self, world) -> None:
        self.world = world
        self._drawn: int | None = None
        self._lit: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What the numbers of `Frame.ids` stand for: objectIds, then structures."""
        self._follow()
        return self._mesh.names

    def _follow(self) -> None:
        if self._drawn == self.world.version:
            return
        self._shared = _plan(self.world)
        now = scene_mesh.changes(self.world)
        moved = self._shared.meshes.posed(now.placements)
        untouched = self._shared.meshes.untouched
        self._mesh = scene_mesh.joined(untouched, moved) if len(moved.triangles) else untouched
        self._caster = rays.Caster(self._shared.fixed(now.displaced), len(untouched.triangles), moved)
        self._drawn = self.world.version

    def _light(self) -> lights.Rig:
        if self._lit != self.world.version:
            low, high = self._shared.low, self._shared.high
            boxes = {o: body.box for o, body in self.world.bodies.items() if body.present and o in self.world.plan}
            self._rig = lights.rig(lights.of_plan(self.world.plan, low, high, boxes), low, high)
            self._lit = self.world.version
        return self._rig

    def frame(self, view: View, rgb: bool = True, depth: bool = False, ids: bool = False, normals: bool = False) -> Frame:
        """One picture of the world as it is now, with what is asked for."""
        if not (rgb or depth or ids or normals):
            return Frame()
        self._follow()
        shape = (view.height, view.width)
        hits = self._cast(view, *_centres(view.width, view.height))
        number, planar = np.empty(len(hits.prim), np.int32), np.empty(len(hits.prim), np.float32)
        shading.identify(
            hits.prim, hits.distance, self._mesh.instance, np.float32(view.near_m), np.float32(view.far_m), number, planar
        )
        picture = facing = None
        if rgb or normals:
            points, facing, footprint = self._surface(view, hits)
            if rgb:
                picture = self._shade(view, hits, points, facing, footprint, number, planar).reshape(*shape, 3)
        return Frame(
            picture,
            planar.reshape(shape) if depth else None,
            number.reshape(shape) if ids else None,
            facing.reshape(*shape, 3) if normals else None,
        )

    def _cast(self, view: View, columns: np.ndarray, rows: np.ndarray) -> _Hits:
        origins, ways = np.empty((len(columns), 3), np.float32), np.empty((len(columns), 3), np.float32)
        flat = view.orthographic_size is not None
        tall = view.orthographic_size if flat else np.tan(np.radians(view.fov_deg) / 2)
        wide = tall * view.width / view.height
        shading.primary(
            *view.axes().astype(np.float32), np.float32(wide), np.float32(tall), np.asarray(view.position, dtype=np.float32),
            np.float32(view.near_m), flat, columns, rows, view.width, view.height, origins, ways,
        )  # fmt: skip
        return _Hits(columns, rows, origins, ways, *self._caster.closest(origins, ways))

    def _surface(self, view: View, hits: _Hits) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        count = len(hits.prim)
        points, facing = np.zeros((count, 3), np.float32), np.zeros((count, 3), np.float32)
        footprint = np.zeros(count, np.float32)
        flat = view.orthographic_size is not None
        pixel = 2 * (view.orthographic_size if flat else np.tan(np.radians(view.fov_deg) / 2)) / view.height
        shading.surface(
            hits.prim, hits.u, hits.v, hits.distance, hits.origins, hits.rays, self._mesh.normals, np.float32(pixel), flat,
            points, facing, footprint,
        )  # fmt: skip
        return points, facing, footprint

    def _colour(self, hits: _Hits, points: np.ndarray, footprint: np.ndarray) -> np.ndarray:
        mesh, looks = self._mesh, self._shared.looks
        colour = np.empty((len(hits.prim), 3), np.float32)
        textures.albedo(
            hits.prim, points, footprint, mesh.material, mesh.part, mesh.axis, mesh.frames, mesh.extents,
            looks.colours, looks.kinds, looks.scales, looks.seeds, looks.emissions, textures.noise(), colour,
        )  # fmt: skip
        return colour

    def _shade(self, view, hits, points, facing, footprint, number, planar) -> np.ndarray:
        rig, looks, width, height = self._light(), self._shared.looks, view.width, view.height
        wide, high = (width + 1) // 2, (height + 1) // 2
        total = wide * high
        starts, ways, reach = (
            np.empty((2 * total, 3), np.float32),
            np.empty((2 * total, 3), np.float32),
            np.empty(2 * total, np.float32),
        )
        weight, even, grid = np.empty(total, np.float32), np.empty(total, np.float32), np.empty((total, shading.GRID), np.float32)
        slots = np.empty((total, 2), np.int32)
        count = shading.coarse(
            hits.prim, points, facing, width, height, wide, high, rig.lights, rig.shadowed, rig.samples, shading.directions(),
            np.float32(shading.REACH_M), starts, ways, reach, slots, weight, even, grid,
        )  # fmt: skip
        blocked = self._caster.occluded(starts[:count], ways[:count], reach[:count])
        shading.soften(blocked, slots, weight, even, grid, np.asarray(view.position, dtype=np.float32), wide, high)

        def light(of: _Hits, where: np.ndarray, toward: np.ndarray, wideness: np.ndarray) -> np.ndarray:
            out = np.empty((len(of.prim), 3), np.float32)
            shading.shade(
                of.prim, where, toward, of.rays, self._colour(of, where, wideness), of.columns, of.rows, grid, wide, high,
                self._mesh.material, looks.glosses, looks.emissions, rig.lights, rig.ambient, np.float32(rig.exposure), SKY, out,
            )  # fmt: skip
            return out

        linear = light(hits, points, facing, footprint)
        pixels = np.empty(width * height, np.int64)
        pixels = pixels[: shading.edges(number, planar, facing, linear, width, height, pixels)]
        offsets = np.tile(SAMPLES, (len(pixels), 1))
        spots = np.repeat(pixels, len(SAMPLES))
        more = self._cast(view, hits.columns[spots] + offsets[:, 0], hits.rows[spots] + offsets[:, 1])
        extra = light(more, *self._surface(view, more))
        picture = np.empty((width * height, 3), np.uint8)
        shading.develop(linear, shading.curve(), extra, pixels, len(SAMPLES), picture)
        return picture
