"""One picture through both networks of the settings, in a process of its own: `python -m ovman.doctor.networks config.yaml`.

A library that the processor does not support kills the importing process, and PyTorch, where it runs the networks, takes seconds.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

LIBRARIES = ("onnxruntime", "torch", "ultralytics", "open_clip_torch")
"""Those that the process has imported are named."""
NOUN = "chair"
SLACK = 1e-3
"""Tolerance of the length of a unit embedding."""
T = TypeVar("T")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the timing of both networks of a configuration file as JSON: start_s, detector_ms, encoder_ms, device, libraries.

    Exit status 2 and one line on standard error if weights are not available.
    """
    (file,) = sys.argv[1:] if arguments is None else arguments
    from ovman.perception.networks import detector_of, encoder_of
    from ovman.perception.weights import WeightsError
    from ovman.settings.config import load

    settings = load(Path(file))
    began = time.perf_counter()
    try:
        detector, encoder = detector_of(settings.perception), encoder_of(settings.perception)
    except WeightsError as error:
        print(error, file=sys.stderr)
        return 2
    start_s = time.perf_counter() - began
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (settings.camera.height_px, settings.camera.width_px, 3), np.uint8)
    crop = rng.integers(0, 256, (1, encoder.side_px, encoder.side_px, 3), np.uint8)
    (seen,), detector_ms = _second(lambda: detector.detect([picture]))
    features, encoder_ms = _second(lambda: np.concatenate([encoder.images(crop), encoder.texts([NOUN])]))
    if seen.masks.shape[1:] != picture.shape[:2] or not np.allclose(np.linalg.norm(features, axis=1), 1, atol=SLACK):
        raise RuntimeError("the output of the networks is not masks and unit embeddings")
    found = {
        "start_s": start_s,
        "detector_ms": detector_ms,
        "encoder_ms": encoder_ms,
        "device": settings.perception.device,
        "libraries": {name: version(name) for name in LIBRARIES if name.removesuffix("_torch") in sys.modules},
    }
    print(json.dumps(found))
    return 0


def _second(work: Callable[[], T]) -> tuple[T, float]:
    """Result and milliseconds of the second of two calls; the first one initialises libraries."""
    work()
    began = time.perf_counter()
    result: Any = work()
    return result, 1e3 * (time.perf_counter() - began)


if __name__ == "__main__":
    sys.exit(main())
