"""Measures several kinds of work in turns, so that the load of the machine affects all of them alike."""

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


def processor_s(pid: int | None) -> float:
    """Processor seconds of this process and another one; Linux numbers the clocks of other processes like this."""
    return time.process_time() + (0.0 if pid is None else time.clock_gettime((~pid << 3) | 2))


def taken(
    kinds: Mapping[str, Callable[[], object]], repeats: int, helpers: Mapping[str, int]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Wall and processor seconds (repeats,) of each kind, after two calls that do not count.

    `helpers`: kind -> process that works for it while this one waits. On a busy machine a long call is interrupted more often
    than a short one; processor time is not affected.
    """
    wall: dict[str, list[float]] = {name: [] for name in kinds}
    processor: dict[str, list[float]] = {name: [] for name in kinds}
    for call in kinds.values():
        call()
        call()
    for _ in range(repeats):
        for name, call in kinds.items():
            start, busy = time.perf_counter(), processor_s(helpers.get(name))
            call()
            wall[name].append(time.perf_counter() - start)
            processor[name].append(processor_s(helpers.get(name)) - busy)
    return tuple({name: np.array(values) for name, values in table.items()} for table in (wall, processor))
