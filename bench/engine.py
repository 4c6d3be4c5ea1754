"""What the engine costs a client: start, reset, steps with and without image, memory. `python bench/engine.py`.

Times are wall clock on this machine, minimum and median; ratios compare figures of this one run.
"""

from __future__ import annotations

import os
import platform
import shlex
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from ovman.engine import executable

SCENE, OTHERS = "FloorPlan201", ("FloorPlan1", "FloorPlan330", "FloorPlan423")
SETTINGS = {"snapToGrid": False, "rotateStepDegrees": 30, "renderDepthImage": True, "renderInstanceSegmentation": True}


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
    """From the start of the process to the end of its first message."""
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


def main() -> None:
    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)
    from ai2thor.controller import Controller

    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{'milliseconds':<58}{'min':>10}{'median':>10}")
    row("start of the process to its first event", [first_event_ms() for _ in range(5)])

    blind = []
    for _ in range(3):
        start = time.perf_counter()
        controller = Controller(local_executable_path=executable(), scene=SCENE, renderImage=False, **SETTINGS)
        blind.append((time.perf_counter() - start) * 1e3)
        without_image = resident_mb(controller.unity_pid)
        controller.stop()
    row(f"Controller(...) on {SCENE} without images", blind)
    controller = Controller(local_executable_path=executable(), scene=SCENE, renderImage=False, **SETTINGS)
    row("  and the first image", timed(lambda: controller.step("RotateRight"), 1))

    def step(action: str, image: bool = False, **arguments: Any) -> Callable[[], Any]:
        return lambda: controller.step(action=action, renderImage=image, **arguments)

    turning = timed(step("RotateRight"), 200)
    row("step without image (RotateRight)", turning)
    row("step in which nothing changes (Pass)", timed(step("Pass"), 200), "a patch of the event before")
    row("GetReachablePositions", timed(step("GetReachablePositions"), 50))
    chair = next(o for o in controller.last_event.metadata["objects"] if o["objectType"] == "Chair")
    forced = {"objectId": chair["objectId"], "forceAction": True, "forceKinematic": True, "rotation": chair["rotation"]}
    places = iter([{**chair["position"], "y": 1.0 + 0.001 * i} for i in range(200)])
    row("TeleportObject of a mover", timed(lambda: step("TeleportObject", position=next(places), **forced)(), 100))
    controller.reset(SCENE)

    controller.step("Pass")
    frames = timed(step("RotateRight", image=True), 48)
    row("step with 300x300 RGB, depth, ids", frames, f"{min(frames) / min(turning):.1f} x a step without image")
    first = {scene: timed(lambda scene=scene: controller.reset(scene, renderImage=True), 1)[0] for scene in OTHERS}
    row("reset to a scene, its first image included", list(first.values()))
    again = [timed(lambda scene=scene: controller.reset(scene, renderImage=True), 1)[0] for scene in OTHERS * 3]
    row("reset to one of the last scenes, image included", again)
    with_images, peak = resident_mb(controller.unity_pid), resident_mb(controller.unity_pid, "VmHWM")
    controller.stop()

    wire = alone()
    row("the same frame inside the process", wire, f"wire and client take {1 - min(wire) / min(frames):.0%} of the step")
    note = f"without images, with images of {len(OTHERS) + 1} scenes (peak {peak:.0f})"
    print(f"\n{'resident MB':<58}{without_image:10.0f}{with_images:10.0f}  {note}")


def alone() -> list[float]:
    """The engine's own share of a step with images."""
    from ovman.engine.engine import Engine

    engine = Engine()
    engine.answer(b'{"action": "Reset", "sceneName": "%s_physics"}' % SCENE.encode())
    engine.answer(
        b'{"action": "Initialize", "snapToGrid": false, "rotateStepDegrees": 30, "renderDepthImage": true, '
        b'"renderInstanceSegmentation": true}'
    )
    return timed(lambda: engine.answer(b'{"action": "RotateRight"}'), 48)


if __name__ == "__main__":
    main()
