"""The bare cast that frames are compared with: the primary rays of a view against one Embree scene of everything drawn.

This is embreex as it comes: its scene at its default quality, its `run` on arrays of origins and directions, nearest hits, no
shading. The engine builds a tree of lower quality, in less time, and casts packets of sixteen rays; `packets` measures that cast
alone on the same tree, which shows the share of shading.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ovman_engine.picture import optics, rays, scene_mesh
from ovman_engine.picture.camera import View
from ovman_engine.world.world import World


def _camera(view: View) -> tuple[object, ...]:
    tall = np.float32(np.tan(np.radians(view.fov_deg) / 2))
    return (
        *view.axes().astype(np.float32), tall * np.float32(view.width / view.height), tall,
        np.asarray(view.position, np.float32), np.float32(view.near_m), False,
    )  # fmt: skip


def cast(world: World, view: View) -> Callable[[], object]:
    """embreex, ray by ray."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    mesh = scene_mesh.build(world)
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices, mesh.triangles)
    rows, columns = np.mgrid[0 : view.height, 0 : view.width].astype(np.float32) + np.float32(0.5)
    origins, ways = np.empty((rows.size, 3), np.float32), np.empty((rows.size, 3), np.float32)
    optics.primary(*_camera(view), columns.ravel(), rows.ravel(), view.width, view.height, origins, ways)
    return lambda: scene.run(origins, ways)


def packets(world: World, view: View) -> Callable[[], object]:
    """The engine's own primary rays."""
    mesh = scene_mesh.build(world)
    nothing = scene_mesh.of_plan(world.plan, world.room).posed([])
    caster = rays.Caster(rays.committed(mesh), len(mesh.triangles), nothing)
    return lambda: caster.view(*_camera(view), np.float32(view.far_m - view.near_m), view.width, view.height)
