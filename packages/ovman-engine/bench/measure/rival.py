"""MuJoCo's renderer on the triangles of a floor plan: RGB, depth and segmentation of one view.

It runs in its own process, because MuJoCo selects its rendering library when it is imported.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ovman_engine.picture.camera import View
    from ovman_engine.world.world import World

LIBRARIES = ("egl", "osmesa")
TO_MUJOCO = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
"""Unity's axes (y up, left-handed) to MuJoCo's (z up, right-handed)."""


class Unavailable(Exception):
    """No library renders for MuJoCo on this machine. The message lists their errors."""


class Rival:
    """A process that draws a floor plan from its start with MuJoCo, on the cores of this process."""

    def __init__(self, scene: str, width: int, height: int, plain: bool) -> None:
        """Raises Unavailable if neither EGL nor OSMesa works."""
        why = []
        for name in LIBRARIES:
            # Mesa then draws in the caller's thread: on one core, others would only wait for each other
            environment = {**os.environ, "MUJOCO_GL": name, "LP_NUM_THREADS": "0"}
            self._process = subprocess.Popen(
                [sys.executable, "-m", "measure.rival", scene, str(width), str(height), "plain" * plain],
                env=environment, cwd=Path(__file__).parents[1], text=True, bufsize=1,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            )  # fmt: skip
            self.about = self._process.stdout.readline().strip()
            if self.about:
                return
            said = self._process.communicate()[1].strip().splitlines()
            why.append(f"{name}: {said[-1] if said else 'ended without a word'}")
        raise Unavailable("; ".join(why))

    def draw(self) -> None:
        """The three pictures of the view."""
        self._process.stdin.write("draw\n")
        if not self._process.stdout.readline():
            raise RuntimeError("the process that draws with MuJoCo has ended")

    @property
    def pid(self) -> int:
        return self._process.pid

    def stop(self) -> None:
        self._process.communicate()


def drawing(world: World, view: View, plain: bool = False) -> tuple[Callable[[], tuple[np.ndarray, ...]], int]:
    """A call that draws RGB, depth and segmentation of the view, and the number of triangles. `plain`: without shadows and
    multisampling, MuJoCo's fastest; else with its defaults.
    """
    import mujoco

    from ovman_engine.picture import scene_mesh

    mesh = scene_mesh.build(world)
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = view.width, view.height
    spec.stat.extent = extent = float(np.ptp(mesh.vertices, axis=0).max())
    spec.visual.map.znear, spec.visual.map.zfar = view.near_m / extent, view.far_m / extent
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    lamp = TO_MUJOCO @ [(low[0] + high[0]) / 2, high[1] - 0.12, (low[2] + high[2]) / 2]
    spec.worldbody.add_light(pos=lamp, dir=[0, 0, -1], castshadow=not plain)
    if plain:
        spec.visual.quality.offsamples = 0
    triangles = 0
    for instance, (vertices, faces) in mesh.spans.items():
        corners = mesh.triangles[faces] - vertices.start
        spec.add_mesh(
            name=str(instance),
            uservert=(mesh.vertices[vertices] @ TO_MUJOCO.T).ravel(),
            userface=corners[:, ::-1].ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        colour = np.sqrt(np.clip(mesh.materials[mesh.material[faces.start]].colour, 0, 1))
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=str(instance), contype=0, conaffinity=0, rgba=[*colour, 1]
        )
        triangles += len(corners)
    right, up, forward = view.axes() @ TO_MUJOCO.T
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, np.column_stack([right, up, -forward]).ravel())
    spec.worldbody.add_camera(name="eye", pos=TO_MUJOCO @ view.position, quat=turn, fovy=view.fov_deg)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = mujoco.Renderer(model, view.height, view.width, max_geom=2 * len(mesh.spans) + 100)

    def draw() -> tuple[np.ndarray, ...]:
        renderer.update_scene(data, camera="eye")
        rgb = renderer.render()
        renderer.enable_depth_rendering()
        depth = renderer.render()
        renderer.disable_depth_rendering()
        renderer.enable_segmentation_rendering()
        ids = renderer.render()
        renderer.disable_segmentation_rendering()
        return rgb, depth, ids

    return draw, triangles


def main(scene: str, width: str, height: str, plain: str) -> int:
    from ovman_engine.picture.camera import View
    from ovman_engine.plan import floorplan
    from ovman_engine.world.world import World

    world = World(floorplan.load(scene))
    view = View(world.agent.camera, world.agent.yaw_deg, width=int(width), height=int(height))
    draw, triangles = drawing(world, view, bool(plain))
    draw()
    from OpenGL import GL

    name = GL.glGetString(GL.GL_RENDERER).decode()
    print(f"{os.environ['MUJOCO_GL']}, {name}, {triangles} triangles", flush=True)
    for _ in sys.stdin:
        draw()
        print("drawn", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
