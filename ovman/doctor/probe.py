"""One frame through the real Controller, in a process of its own: `python -m ovman.doctor.probe embedded`.

The client waits forever for a simulator that dies early, so the caller of this program must set a time limit.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

SCENE = "FloorPlan201"
REPEATS = 8
"""Frames; the fastest one counts."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a frame's timing and size for a backend ("embedded", "thor") as JSON.

    Keys: start_s, frame_ms, resident_mb, size_px, objects.
    """
    (backend,) = sys.argv[1:] if arguments is None else arguments
    from ovman.sim import controller
    from ovman.sim.embodiment import Embodiment

    began = time.perf_counter()
    simulator = controller.start(backend, SCENE, Embodiment(300, 300, 90.0, 0.25, 30.0))
    start_s = time.perf_counter() - began
    try:
        simulator.step("RotateRight")
        times = []
        for _ in range(REPEATS):
            began = time.perf_counter()
            event = simulator.step("RotateRight")
            times.append(time.perf_counter() - began)
        masks = event.instance_masks
        if event.frame.std() == 0 or not (event.depth_frame > 0).all() or not len(masks):
            raise RuntimeError("the frame is empty")
        found = {
            "start_s": start_s,
            "frame_ms": 1e3 * min(times),
            "resident_mb": _resident_mb(simulator.server.unity_proc.pid),
            "size_px": list(event.frame.shape[1::-1]),
            "objects": len(event.metadata["objects"]),
        }
    finally:
        simulator.stop()
    print(json.dumps(found))
    return 0


def _resident_mb(pid: int) -> float:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS:"))


if __name__ == "__main__":
    sys.exit(main())
