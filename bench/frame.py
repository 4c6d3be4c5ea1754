"""What a frame costs, on one core, as ratios to a bare Embree cast of the same rays over the same triangles.

    python bench/frame.py [--scene FloorPlan201] [--repeats 40]

The measured kinds take turns, so that they share whatever else the machine does; each prints its least and its median time, and
the ratio of the least and of the medians to those of the bare cast. The last line compares the frame through the real ai2thor
Controller with the bar.
"""

from __future__ import annotations

import argparse
import itertools
import os
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ovman.engine import floorplan, optics, rays, scene_mesh
from ovman.engine.camera import Renderer, View
from ovman.engine.world import World

BAR = 3.5
"""Frame through the Controller over bare cast."""


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def bare_cast(world: World, view: View) -> Callable[[], object]:
    """The primary rays of a view against one Embree scene of everything that is drawn."""
    scene = rays.committed(scene_mesh.build(world))
    rows, columns = np.mgrid[0 : view.height, 0 : view.width].astype(np.float32) + np.float32(0.5)
    origins, ways = np.empty((rows.size, 3), np.float32), np.empty((rows.size, 3), np.float32)
    half = np.float32(np.tan(np.radians(view.fov_deg) / 2))
    optics.primary(
        *view.axes().astype(np.float32), half * np.float32(view.width / view.height), half, np.asarray(view.position, np.float32),
        np.float32(view.near_m), False, columns.ravel(), rows.ravel(), view.width, view.height, origins, ways,
    )  # fmt: skip
    return lambda: scene.run(origins, ways)


def taken(kinds: dict[str, Callable[[], object]], repeats: int) -> dict[str, np.ndarray]:
    """Wall seconds (repeats,) of each kind."""
    times: dict[str, list[float]] = {name: [] for name in kinds}
    for call in kinds.values():
        call()
        call()
    for _ in range(repeats):
        for name, call in kinds.items():
            start = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - start)
    return {name: np.array(values) for name, values in times.items()}


def mover(world: World) -> Callable[[], object]:
    """Shifts one movable object to and fro."""
    obj = next(o for o in world.plan.objects if o.moveable)
    state = {"side": 1.0}

    def shift() -> None:
        state["side"] = -state["side"]
        position = obj.position + [0.05 * state["side"], 0.5, 0.0]
        world.teleport(obj.object_id, position, None, True, True)

    return shift


def controller_frame(scene: str, view: View):
    """(call, stop) of a frame through the real Controller with RGB, depth and ids; the agent looks to and fro by half a
    degree: the engine draws no view twice."""
    from ai2thor.controller import Controller

    import ovman.engine

    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)
    controller = Controller(
        local_executable_path=ovman.engine.executable(), scene=scene, width=view.width, height=view.height,
        renderDepthImage=True, renderInstanceSegmentation=True, snapToGrid=False,
    )  # fmt: skip
    turns = itertools.cycle(["RotateRight", "RotateLeft"])
    return (lambda: controller.step(next(turns), degrees=0.5)), controller.stop


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="FloorPlan201")
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--size", type=int, default=300)
    options = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})

    plan = floorplan.load(options.scene)
    start = time.perf_counter()
    world = World(plan)
    renderer = Renderer(world)
    view = View(world.agent.camera, world.agent.yaw_deg, width=options.size, height=options.size)
    renderer.frame(view, rgb=False, ids=True)
    first = time.perf_counter() - start
    renderer.frame(view)
    moved_world = World(plan)
    moved = Renderer(moved_world)
    shift = mover(moved_world)

    def move_and_see(**what: bool) -> Callable[[], object]:
        def call() -> None:
            shift()
            moved.frame(view, **what)

        return call

    kinds: dict[str, Callable[[], object]] = {
        "bare cast": bare_cast(world, view),
        "ids + depth": lambda: renderer.frame(view, rgb=False, depth=True, ids=True),
        "RGB + depth + ids": lambda: renderer.frame(view, depth=True, ids=True),
        "one object moved, ids + depth": move_and_see(rgb=False, depth=True, ids=True),
        "one object moved, all": move_and_see(depth=True, ids=True),
        "Embree scene from scratch": lambda: rays.committed(scene_mesh.build(world)),
        "mesh of one move": lambda: (shift(), moved.names),
    }
    stop = None
    try:
        kinds["Controller, RGB + depth + ids"], stop = controller_frame(options.scene, view)
    except (ImportError, AttributeError) as missing:
        print(f"no frame through the Controller: {missing}", file=sys.stderr)
    try:
        times = taken(kinds, options.repeats)
    finally:
        if stop is not None:
            stop()

    triangles, size = len(scene_mesh.build(world).triangles), f"{options.size} x {options.size}"
    print(f"{options.scene}, {size}, {triangles} triangles; {processor()}, one core, {options.repeats} times")
    print(f"meshes, Embree scene and first ids: {first * 1e3:.0f} ms")
    print(f"{'':32s}{'least ms':>10s}{'median ms':>11s}{'x bare':>9s}{'x bare (median)':>17s}")
    bare = times["bare cast"]
    for name, values in times.items():
        ratio, middle = values.min() / bare.min(), np.median(values) / np.median(bare)
        print(f"{name:32s}{values.min() * 1e3:10.2f}{np.median(values) * 1e3:11.2f}{ratio:9.2f}{middle:17.2f}")
    through = times.get("Controller, RGB + depth + ids")
    if through is not None:
        print(
            f"Controller: {np.median(through) / np.median(bare):.2f} x bare (least {through.min() / bare.min():.2f}); bar {BAR}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
