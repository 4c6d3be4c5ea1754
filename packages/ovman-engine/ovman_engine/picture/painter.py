"""Draws views of triangle meshes with the kernels: materials, light and cameras as they take them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ovman_engine import kernels
from ovman_engine.paint import textures
from ovman_engine.paint.materials import Material
from ovman_engine.picture.lights import Rig
from ovman_engine.picture.triangle_mesh import TriangleMesh

CURVE = 4096
"""Entries of the table from linear light to eight bits; as in kernels/paint.hpp."""
BRIGHTEST = 4.0
"""Linear light of its last entry."""
KNEE = 0.55
"""Linear light above which the curve bends."""


@cache
def curve() -> np.ndarray:
    """(CURVE,) float32: displayed value 0..255 of linear light 0..BRIGHTEST: a soft shoulder, then the sRGB curve."""
    light = np.linspace(0, BRIGHTEST, CURVE)
    light = np.where(light < KNEE, light, KNEE + (1 - KNEE) * (1 - np.exp(-(light - KNEE) / (1 - KNEE))))
    shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return np.round(np.clip(shown, 0, 1) * 255, 3).astype(np.float32)


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
            np.array([m.seed & 0x7FFFFFFF for m in materials], dtype=np.int32),
            np.array([m.gloss for m in materials], dtype=np.float32),
            np.array([m.emission for m in materials], dtype=np.float32),
            np.array([m.clear for m in materials], dtype=bool),
        )

    def packed(self) -> kernels.Materials:
        """Return the materials as the kernels take them."""
        return kernels.Materials(self.colours, self.kinds, self.scales, self.seeds, self.glosses, self.emissions, self.clear)


def solid(mesh: TriangleMesh) -> kernels.Solid:
    """Return the mesh as the kernels take it; its arrays must not be written to afterwards."""
    return kernels.Solid(
        mesh.vertices, mesh.triangles, mesh.normals, mesh.instance, mesh.material, mesh.part, mesh.axis, mesh.frames, mesh.extents
    )


def rig(lights: Rig) -> kernels.Rig:
    """Return the lights as the kernels take them."""
    none = np.zeros((0, 3), np.float32)
    sun = none if lights.sun is None else np.stack([lights.sun.way, lights.sun.colour])
    panes = np.zeros((0, 6), np.float32) if lights.sun is None else lights.sun.panes
    return kernels.Rig(lights.lights, lights.shadowed, lights.samples, lights.ambient, lights.exposure, sun, panes)


def camera(view) -> kernels.Camera:
    """Return a camera.View as the kernels take it."""
    flat = view.orthographic_size is not None
    tall = view.orthographic_size if flat else np.tan(np.radians(view.fov_deg) / 2)
    return kernels.Camera(
        np.asarray(view.position, np.float32), view.axes().astype(np.float32), tall * view.width / view.height, tall,
        view.near_m, view.far_m, view.width, view.height, flat,
    )  # fmt: skip
