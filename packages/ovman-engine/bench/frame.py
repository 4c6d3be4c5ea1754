"""Cost of a frame on one core, beside MuJoCo's of the same triangles.

    python bench/frame.py [--scene FloorPlan201] [--repeats 30]

The measured kinds take turns, so that the load of the machine affects all of them alike. Each prints its least and its median
wall time, the least processor time of this process and the one behind it, and the ratio of that to a frame inside the process.
MuJoCo draws the same triangles from the same place, with its defaults and at its fastest. The last table compares the figures
with their bounds.
"""

from __future__ import annotations

import argparse
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from measure.bars import Bar, show
from measure.clock import processor, taken
from measure.rival import Rival, Unavailable
from ovman_engine.picture import painter, scene_mesh
from ovman_engine.picture.camera import Renderer, View
from ovman_engine.plan import floorplan
from ovman_engine.world.world import World

SMALL, LARGE = (300, 300), (640, 480)
BARS = {SMALL: 2.2, LARGE: 1.5}
"""Time of a frame through the Controller over that of a frame inside the process."""
RIVAL_BAR = 10.0
"""MuJoCo's time over that of a frame inside the process."""
FRAME, CONTROLLER = "RGB + depth + ids", "RGB + depth + ids, Controller"
RIVAL, RIVAL_PLAIN = "MuJoCo, RGB + depth + ids", "MuJoCo, no shadows, 1 sample"


def mover(world: World) -> Callable[[], object]:
    """Moves one movable object to and fro."""
    obj = next(o for o in world.plan.objects if o.moveable)
    state = {"side": 1.0}

    def shift() -> None:
        state["side"] = -state["side"]
        position = obj.position + [0.05 * state["side"], 0.5, 0.0]
        world.teleport(obj.object_id, position, None, True, True)

    return shift


@contextmanager
def controller_frame(scene: str, width: int, height: int) -> Iterator[tuple[Callable[[], object], int]]:
    """A call for a frame through the Controller with RGB, depth and ids, and the engine's process id. The agent turns to and fro
    by half a degree, because the engine draws no view twice.
    """
    from ai2thor.controller import Controller

    import ovman_engine

    controller = Controller(
        local_executable_path=ovman_engine.executable(), scene=scene, width=width, height=height,
        renderDepthImage=True, renderInstanceSegmentation=True, snapToGrid=False,
    )  # fmt: skip
    turns = itertools.cycle(["RotateRight", "RotateLeft"])
    try:
        yield (lambda: controller.step(next(turns), degrees=0.5)), controller.unity_pid
    finally:
        controller.stop()


def measure(scene: str, size: tuple[int, int], repeats: int) -> list[Bar]:
    width, height = size
    plan = floorplan.load(scene)
    world, moved_world = World(plan), World(plan)
    renderer, moved = Renderer(world), Renderer(moved_world)
    view = View(world.agent.camera, world.agent.yaw_deg, width=width, height=height)
    shift = mover(moved_world)

    def move_and_see(**what: bool) -> Callable[[], object]:
        def call() -> None:
            shift()
            moved.frame(view, **what)

        return call

    kinds: dict[str, Callable[[], object]] = {
        "ids + depth": lambda: renderer.frame(view, rgb=False, depth=True, ids=True),
        FRAME: lambda: renderer.frame(view, depth=True, ids=True),
    }
    notes = dict.fromkeys(kinds, "")
    if size == SMALL:
        kinds |= {
            "one object moved, ids + depth": move_and_see(rgb=False, depth=True, ids=True),
            "one object moved, all": move_and_see(depth=True, ids=True),
            "tree of all triangles": lambda: painter.solid(scene_mesh.build(world)),
            "mesh of one move": lambda: (shift(), moved.names),
        }
    helpers: dict[str, int] = {}
    with ExitStack() as stack:
        kinds[CONTROLLER], helpers[CONTROLLER] = stack.enter_context(controller_frame(scene, width, height))
        for name, plain in ((RIVAL, False), (RIVAL_PLAIN, True)):
            try:
                rival = Rival(scene, width, height, plain)
            except Unavailable as why:
                print(f"no frame of MuJoCo to compare with: {why}")
                break
            stack.callback(rival.stop)
            kinds[name], helpers[name], notes[name] = rival.draw, rival.pid, rival.about
        wall, busy = taken(kinds, repeats, helpers)

    triangles = len(scene_mesh.build(world).triangles)
    print(f"\n{scene}, {width} x {height}, {triangles} triangles; {processor()}, one core, {repeats} times")
    print(f"{'milliseconds':34s}{'least':>9s}{'median':>9s}{'processor':>11s}{'x frame':>9s}")
    least = {name: values.min() * 1e3 for name, values in busy.items()}
    for name, values in wall.items():
        shown = f"{values.min() * 1e3:9.2f}{np.median(values) * 1e3:9.2f}{least[name]:11.2f}{least[name] / least[FRAME]:9.2f}"
        print(f"{name:34s}{shown}  {notes.get(name, '')}")
    share = least[CONTROLLER] - least[FRAME]
    print(f"metadata, pipe and client {share:.2f} ms")
    found = [Bar(f"{width} x {height} through the Controller, x inside", least[CONTROLLER] / least[FRAME], BARS[size], "x")]
    if size == SMALL:
        beaten = least[RIVAL] / least[FRAME] if RIVAL in least else None
        found.append(Bar(f"MuJoCo's time over the engine's, {width} x {height}", beaten, RIVAL_BAR, "x", at_least=True))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="FloorPlan201")
    parser.add_argument("--repeats", type=int, default=30)
    options = parser.parse_args()
    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    show([bar for size in BARS for bar in measure(options.scene, size, options.repeats)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
