"""Cost of the engine for a client: start, reset, steps with and without images, memory, two engines at once.

    python bench/engine.py

Times are wall clock on this machine, least and median; ratios compare figures of one run. Resets are also measured in processor
time, because on a busy machine every one of them is interrupted. The last table compares the figures with their bounds.
"""

from __future__ import annotations

import os
import platform
import shlex
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from measure.bars import Bar, show
from measure.clock import processor, processor_s
from ovman_engine import executable

SCENE, OTHERS = "FloorPlan201", ("FloorPlan1", "FloorPlan330", "FloorPlan423", "FloorPlan7", "FloorPlan212", "FloorPlan305")
SETTINGS = {"snapToGrid": False, "rotateStepDegrees": 30, "renderDepthImage": True, "renderInstanceSegmentation": True}
BARS = {"start": 1500.0, "step": 3.0, "reset": 150.0, "memory": 200.0, "pair": 1.8}
"""Milliseconds, megabytes, and the number of frames of two engines relative to one."""
PAIR_FRAMES = 60


def timed(function: Callable[[], Any], times: int) -> list[float]:
    """Milliseconds of each call."""
    found = []
    for _ in range(times):
        start = time.perf_counter()
        function()
        found.append((time.perf_counter() - start) * 1e3)
    return found


def row(name: str, found: list[float], note: str = "") -> None:
    print(f"{name:<58}{min(found):10.2f}{median(found):10.2f}  {note}")


def first_event_ms() -> float:
    """Milliseconds from the start of the process to the end of its first message."""
    with tempfile.TemporaryDirectory() as directory:
        pipes = {f"AI2THOR_FIFO_{end}_PIPE_PATH": f"{directory}/{end.lower()}.pipe" for end in ("SERVER", "CLIENT")}
        for path in pipes.values():
            os.mkfifo(path)
        start = time.perf_counter()
        process = subprocess.Popen(shlex.split(executable()), env={**os.environ, **pipes}, stdout=subprocess.DEVNULL)
        with open(pipes["AI2THOR_FIFO_SERVER_PIPE_PATH"], "rb") as pipe:
            while (header := struct.unpack("!BI", pipe.read(5)))[0] != 255:
                pipe.read(header[1])
            elapsed = (time.perf_counter() - start) * 1e3
        process.wait()
        return elapsed


def resident_mb(pid: int, name: str = "VmRSS") -> float:
    line = next(x for x in Path(f"/proc/{pid}/status").read_text().splitlines() if x.startswith(name))
    return int(line.split()[1]) / 1024


@contextmanager
def client(**options: Any) -> Iterator[Any]:
    """The ai2thor Controller on the scene, with the engine."""
    from ai2thor.controller import Controller

    controller = Controller(local_executable_path=executable(), scene=SCENE, **SETTINGS, **options)
    try:
        yield controller
    finally:
        controller.stop()


def step(controller: Any, action: str, image: bool = False, **arguments: Any) -> Callable[[], Any]:
    return lambda: controller.step(action=action, renderImage=image, **arguments)


def steps(controller: Any) -> Bar:
    """Steps without images."""
    turning = timed(step(controller, "RotateRight"), 200)
    row("step without image (RotateRight)", turning)
    walking = [t for way in ("MoveAhead", "MoveBack") * 20 for t in timed(step(controller, way), 1)]
    row("step without image (MoveAhead, MoveBack)", walking)
    row("step in which nothing changes (Pass)", timed(step(controller, "Pass"), 200), "a patch of the event before")
    row("GetReachablePositions", timed(step(controller, "GetReachablePositions"), 20))
    chair = next(o for o in controller.last_event.metadata["objects"] if o["objectType"] == "Chair")
    forced = {"objectId": chair["objectId"], "forceAction": True, "forceKinematic": True, "rotation": chair["rotation"]}
    places = iter([{**chair["position"], "y": 1.0 + 0.001 * i} for i in range(200)])
    row("TeleportObject of a mover", timed(lambda: step(controller, "TeleportObject", position=next(places), **forced)(), 60))
    return Bar("a step without image", min(turning), BARS["step"], "ms")


def resets(controller: Any) -> Bar:
    """Resets with the first image of the scene."""
    new, busy = [], []
    for scene in OTHERS:
        before = processor_s(controller.unity_pid)
        new += timed(lambda scene=scene: controller.reset(scene, renderImage=True), 1)
        busy.append((processor_s(controller.unity_pid) - before) * 1e3)
    each = ", ".join(f"{scene.removeprefix('FloorPlan')} {ms:.0f}" for scene, ms in zip(OTHERS, busy, strict=True))
    row("reset to a scene, its first image included", new)
    row("  time of the processor", busy, each)
    again = [timed(lambda scene=scene: controller.reset(scene, renderImage=True), 1)[0] for scene in OTHERS[-2:] * 4]
    row("reset to one of the last scenes, image included", again)
    return Bar("reset to another scene, processor's time (median)", median(busy), BARS["reset"], "ms")


def pair() -> Bar:
    """Frames that two engines draw at once on two cores, over those of one in the same time."""

    def drawn_in(controllers: list[Any]) -> float:
        def turn(controller: Any) -> None:
            for _ in range(PAIR_FRAMES):
                controller.step("RotateRight")

        # each client decodes in a process of its own in practice; here both are this one, in threads
        with ThreadPoolExecutor(len(controllers)) as pool:
            start = time.perf_counter()
            list(pool.map(turn, controllers))
            return time.perf_counter() - start

    name = "frames of two engines on two cores, x those of one"
    if len(os.sched_getaffinity(0)) < 2:
        return Bar(name, None, BARS["pair"], "x", at_least=True)
    with ExitStack() as stack:
        controllers = [stack.enter_context(client()) for _ in range(2)]
        ratio = max(2 * drawn_in(controllers[:1]) / drawn_in(controllers) for _ in range(4))
    return Bar(name, ratio, BARS["pair"], "x", at_least=True)


def main() -> None:
    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)

    print(f"{processor()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{'milliseconds':<58}{'least':>10}{'median':>10}")
    starts = [first_event_ms() for _ in range(5)]
    row("start of the process to its first event", starts)
    with client(renderImage=False) as controller:
        without_image = resident_mb(controller.unity_pid)
        row("  and the first image", timed(lambda: controller.step("RotateRight"), 1))
        one_scene = resident_mb(controller.unity_pid)
        slow = steps(controller)
    with client() as controller:
        controller.step("Pass")
        frames = timed(step(controller, "RotateRight", image=True), 48)
        row("step with 300x300 RGB, depth, ids", frames)
        reset = resets(controller)
        with_images, peak = resident_mb(controller.unity_pid), resident_mb(controller.unity_pid, "VmHWM")
    wire = alone()
    row("the same frame inside the process", wire, f"wire and client take {1 - min(wire) / min(frames):.0%} of the step")
    print(f"\n{'resident MB':<34}without images {without_image:.0f}; with images of one scene {one_scene:.0f}, of", end=" ")
    print(f"{len(OTHERS) + 1} scenes {with_images:.0f} (peak {peak:.0f})")
    show([
        Bar("start of the process to its first event", min(starts), BARS["start"], "ms"),
        slow,
        reset,
        Bar("resident, images of one scene", one_scene, BARS["memory"], "MB"),
        pair(),
    ])  # fmt: skip


def alone() -> list[float]:
    """The engine's own share of a step with images."""
    from ovman_engine.engine import Engine

    engine = Engine()
    engine.answer(b'{"action": "Reset", "sceneName": "%s_physics"}' % SCENE.encode())
    engine.answer(
        b'{"action": "Initialize", "snapToGrid": false, "rotateStepDegrees": 30, "renderDepthImage": true, '
        b'"renderInstanceSegmentation": true}'
    )
    return timed(lambda: engine.answer(b'{"action": "RotateRight"}'), 48)


if __name__ == "__main__":
    main()
