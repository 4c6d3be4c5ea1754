"""Colours the hits of a view: textures, light, shadow, reflections and smooth edges."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman_engine.paint import textures
from ovman_engine.paint.materials import Material
from ovman_engine.picture import film, optics, shading, sunshine
from ovman_engine.picture.lights import Rig
from ovman_engine.picture.rays import Caster
from ovman_engine.picture.triangle_mesh import TriangleMesh

PANES = 2
"""Number of panes of glass, one behind the other, that are seen through."""
SKY = np.array([0.55, 0.65, 0.75], dtype=np.float32)
"""Linear RGB of the default sky."""


@dataclass(frozen=True)
class Appearance:
    """M materials as arrays: linear RGB (M, 3), texture kinds, scales (metres), seeds, glosses, emissions (M,)."""

    colours: np.ndarray
    kinds: np.ndarray
    scales: np.ndarray
    seeds: np.ndarray
    glosses: np.ndarray
    emissions: np.ndarray
    clear: np.ndarray
    """(M,) bool: glass"""

    @staticmethod
    def of(materials: Iterable[Material]) -> Appearance:
        """Return the arrays of `materials`, in their order."""
        materials = tuple(materials)
        return Appearance(
            np.array([m.colour for m in materials], dtype=np.float32).reshape(-1, 3),
            np.array([textures.KINDS.index(m.texture) for m in materials], dtype=np.int32),
            np.array([m.scale_m for m in materials], dtype=np.float32),
            np.array([m.seed & 0x7FFFFFFF for m in materials], dtype=np.int64),
            np.array([m.gloss for m in materials], dtype=np.float32),
            np.array([m.emission for m in materials], dtype=np.float32),
            np.array([m.clear for m in materials], dtype=bool),
        )


@dataclass(frozen=True)
class Hits:
    """N image points (columns and rows in pixels), their rays, and the hits of those.

    A hit has the triangle (-1 for none), the distance in lengths of the ray, and barycentric coordinates.
    """

    columns: np.ndarray
    rows: np.ndarray
    origins: np.ndarray
    rays: np.ndarray
    prim: np.ndarray
    distance: np.ndarray
    u: np.ndarray
    v: np.ndarray


@dataclass(frozen=True)
class Surface:
    """The surface at N hits: points (N, 3), unit normals (N, 3) towards the eye, width of a pixel (N,) metres.

    Without a hit the normal is 0, and the rest is undefined.
    """

    points: np.ndarray
    normals: np.ndarray
    footprint: np.ndarray


class Painter:
    """Casts and colours the rays of one view of a mesh."""

    def __init__(self, view, mesh: TriangleMesh, looks: Appearance, caster: Caster) -> None:
        """`view`: camera.View."""
        self._view, self._mesh, self._looks, self._caster = view, mesh, looks, caster
        self._flat = view.orthographic_size is not None
        self._tall = view.orthographic_size if self._flat else np.tan(np.radians(view.fov_deg) / 2)

    def _camera(self) -> tuple[Any, Any, Any, Any, Any, Any, Any, Any]:
        """Return the view as arguments of `optics.primary` and `Caster.view`, without width and height."""
        view = self._view
        right, up, forward = view.axes().astype(np.float32)
        return (
            right, up, forward, np.float32(self._tall * view.width / view.height), np.float32(self._tall),
            np.asarray(view.position, dtype=np.float32), np.float32(view.near_m), self._flat,
        )  # fmt: skip

    def _points(self, columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Origins and rays (N, 3) float32 of image points (N,) float32 pixels."""
        view = self._view
        origins, ways = np.empty((len(columns), 3), np.float32), np.empty((len(columns), 3), np.float32)
        optics.primary(*self._camera(), columns, rows, view.width, view.height, origins, ways)
        return origins, ways

    def see(self, columns: np.ndarray, rows: np.ndarray) -> Hits:
        """Return the hits at all pixel centres, row by row, up to the far plane. The centres are given as to `cast`."""
        view = self._view
        met = self._caster.view(*self._camera(), np.float32(view.far_m - view.near_m), view.width, view.height)
        return Hits(columns, rows, *self._points(columns, rows), *met)

    def cast(self, columns: np.ndarray, rows: np.ndarray) -> Hits:
        """Return the hits at image points (N,) float32 pixels."""
        origins, ways = self._points(columns, rows)
        return Hits(columns, rows, origins, ways, *self._caster.closest(origins, ways))

    def surface(self, hits: Hits) -> Surface:
        """Return the surface at the hits."""
        count = len(hits.prim)
        found = Surface(np.empty((count, 3), np.float32), np.empty((count, 3), np.float32), np.empty(count, np.float32))
        optics.surface(
            hits.prim, hits.u, hits.v, hits.distance, hits.origins, hits.rays, self._mesh.normals,
            np.float32(2 * self._tall / self._view.height), self._flat, found.points, found.normals, found.footprint,
        )  # fmt: skip
        return found

    def picture(self, hits: Hits, surface: Surface, rig: Rig, ids: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(H W, 3) uint8: the colours of all pixels in order.

        `hits` are those at their centres; instance ids and depths are (H W,).
        """
        view = self._view
        grid = self._grid(hits, surface, rig)
        linear = self._light(hits, surface, rig, grid)
        pixels = np.empty(len(hits.prim), np.int64)
        aside, down = np.empty(len(hits.prim), np.float32), np.empty(len(hits.prim), np.float32)
        count = film.edges(ids, depth, surface.normals, linear, view.width, view.height, pixels, aside, down)
        pixels = pixels[:count]
        more = self.cast(hits.columns[pixels] + aside[:count], hits.rows[pixels] + down[:count])
        extra = self._light(more, self.surface(more), rig, grid)
        picture = np.empty((len(linear), 3), np.uint8)
        film.develop(linear, film.curve(), extra, pixels, picture)
        return picture

    def _grid(self, hits: Hits, surface: Surface, rig: Rig) -> np.ndarray:
        """Light and shadow at every other pixel, after `shading.soften`."""
        view = self._view
        wide, high = (view.width + 1) // 2, (view.height + 1) // 2
        total = wide * high
        starts, ways = np.empty((2 * total, 3), np.float32), np.empty((2 * total, 3), np.float32)
        reach, weight, even = np.empty(2 * total, np.float32), np.empty(total, np.float32), np.empty(total, np.float32)
        slots, grid = np.empty((total, 2), np.int32), np.empty((total, shading.GRID), np.float32)
        count = shading.coarse(
            hits.prim, surface.points, surface.normals, view.width, view.height, wide, high, rig.lights, rig.shadowed,
            rig.samples, shading.directions(), np.float32(shading.REACH_M), starts, ways, reach, slots, weight, even, grid,
        )  # fmt: skip
        blocked = self._caster.occluded(starts[:count], ways[:count], reach[:count])
        shading.soften(blocked, slots, weight, even, grid, np.asarray(view.position, dtype=np.float32), wide, high)
        if rig.sun is not None:
            self._shine(rig.sun, wide, high, grid)
        return grid

    def _shine(self, sun: sunshine.Sun, wide: int, high: int, grid: np.ndarray) -> None:
        """Add sunlight to the coarse grid."""
        starts, ways = np.empty((wide * high, 3), np.float32), np.empty((wide * high, 3), np.float32)
        reach, which = np.empty(wide * high, np.float32), np.empty(wide * high, np.int64)
        count = sunshine.through(grid, sun.way, sun.panes, starts, ways, reach, which)
        if count:
            blocked = self._caster.occluded(starts[:count], ways[:count], reach[:count])
            sunshine.add(blocked, which[:count], sun.way, sun.colour, wide, high, grid)

    def _colour(self, hits: Hits, surface: Surface) -> np.ndarray:
        mesh, looks = self._mesh, self._looks
        colour = np.empty((len(hits.prim), 3), np.float32)
        textures.albedo(
            hits.prim, surface.points, surface.footprint, mesh.material, mesh.part, mesh.axis, mesh.frames, mesh.extents,
            looks.colours, looks.kinds, looks.scales, looks.seeds, looks.emissions, textures.noise(), colour,
        )  # fmt: skip
        return colour

    def _light(self, hits: Hits, surface: Surface, rig: Rig, grid: np.ndarray, panes: int = PANES) -> np.ndarray:
        """Linear light (N, 3) float32 of image points.

        Mirrors show no other mirrors; through glass the surface behind it is seen, also through the next `panes` - 1 panes.
        """
        view, looks, material = self._view, self._looks, self._mesh.material
        out = np.empty((len(hits.prim), 3), np.float32)
        shading.shade(
            hits.prim, surface.points, surface.normals, hits.rays, self._colour(hits, surface), hits.columns, hits.rows,
            grid, (view.width + 1) // 2, (view.height + 1) // 2, material, looks.glosses, looks.emissions,
            rig.lights, rig.ambient, np.float32(rig.exposure), SKY, out,
        )  # fmt: skip
        if panes:
            which = optics.mirrors(hits.prim, material, looks.glosses if panes == PANES else looks.glosses * looks.clear)
            if len(which):
                starts, ways = np.empty((len(which), 3), np.float32), np.empty((len(which), 3), np.float32)
                gloss = looks.glosses[material[hits.prim[which]]]
                clear = looks.clear[material[hits.prim[which]]]
                optics.mirrored(which, surface.points, surface.normals, hits.rays, clear, starts, ways)
                met = Hits(hits.columns[which], hits.rows[which], starts, ways, *self._caster.closest(starts, ways))
                film.mirror(which, gloss, self._light(met, self.surface(met), rig, grid, panes - 1), out)
        return out
