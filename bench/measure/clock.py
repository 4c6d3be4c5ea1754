"""Kinds of work that take turns, so that they share whatever else the machine does."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def taken(kinds: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, np.ndarray]:
    """Wall seconds (repeats,) of each kind, after two calls of each that are not counted."""
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
