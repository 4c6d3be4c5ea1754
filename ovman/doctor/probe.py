"""Probes in processes of their own: one frame of a simulator, or one picture through both networks.

    python -m ovman.doctor.probe frame embedded
    python -m ovman.doctor.probe networks config.yaml

The client waits forever for a simulator that dies early, and a library that the processor does not support ends its process. The
caller sets a time limit.
"""

from __future__ import annotations

import json
import sys
import time
import timeit
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

SCENE = "FloorPlan201"
NOUN = "chair"
REPEATS = 8
"""Calls that are timed; the fastest one counts."""
LIBRARIES = ("onnxruntime", "torch", "ultralytics", "open_clip_torch")
"""Distributions that are named if the process has imported them."""
TOLERANCE = 1e-3
"""Of the length of a unit embedding."""


def probe_frame(backend: str) -> dict[str, Any]:
    """Return the timing and the size of a frame of a backend, "embedded" or "thor"."""
    from ovman.sim import controller
    from ovman.sim.embodiment import Embodiment

    began = time.perf_counter()
    simulator = controller.start(backend, SCENE, Embodiment(300, 300, 90.0, 0.25, 30.0))
    start_s = time.perf_counter() - began
    try:
        event = simulator.step("RotateRight")
        if event.frame.std() == 0 or not (event.depth_frame > 0).all() or not len(event.instance_masks):
            raise RuntimeError("the frame is empty")
        frame_ms = _fastest_ms(lambda: simulator.step("RotateRight"))
        return {"start_s": start_s, "frame_ms": frame_ms, "size_px": event.frame.shape[1::-1]}
    finally:
        simulator.stop()


def probe_networks(file: str) -> dict[str, Any]:
    """Return the timing of both networks of a configuration file. Raises WeightsError."""
    import numpy as np

    from ovman.perception.networks import detector_of, encoder_of
    from ovman.settings.config import load

    settings = load(Path(file))
    began = time.perf_counter()
    detector, encoder = detector_of(settings.perception), encoder_of(settings.perception)
    start_s = time.perf_counter() - began
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (settings.camera.height_px, settings.camera.width_px, 3), np.uint8)
    crop = rng.integers(0, 256, (1, encoder.side_px, encoder.side_px, 3), np.uint8)
    (seen,), features = detector.detect([picture]), np.concatenate([encoder.images(crop), encoder.texts([NOUN])])
    if seen.masks.shape[1:] != picture.shape[:2] or not np.allclose(np.linalg.norm(features, axis=1), 1, atol=TOLERANCE):
        raise RuntimeError("the output of the networks is not masks and unit embeddings")
    return {
        "start_s": start_s,
        "detector_ms": _fastest_ms(lambda: detector.detect([picture])),
        "encoder_ms": _fastest_ms(lambda: [encoder.images(crop), encoder.texts([NOUN])]),
        "device": settings.perception.device,
        "libraries": {name: version(name) for name in LIBRARIES if name.removesuffix("_torch") in sys.modules},
    }


def _fastest_ms(work: Callable[[], Any]) -> float:
    return 1e3 * min(timeit.repeat(work, number=1, repeat=REPEATS))


def main() -> None:
    """Print a probe's result as JSON. An error that says all ends the process with one line and status 2."""
    what, argument = sys.argv[1:]
    try:
        print(json.dumps({"frame": probe_frame, "networks": probe_networks}[what](argument)))
    except ValueError as error:
        if not getattr(error, "says_all", False):
            raise
        print(error, file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
