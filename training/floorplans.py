"""The floor plans of the training data, none of which the benchmark uses."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from ovman.settings.benchmark import FLOOR_PLANS

HELD_OUT_EVERY = 9
"""Every ninth floor plan is held out, so that every kind of room is."""


@dataclass(frozen=True, slots=True)
class FloorPlans:
    """taught: for training; held_out: for the learning curves and for every choice."""

    taught: tuple[str, ...]
    held_out: tuple[str, ...]


def floor_plans(benchmark: Collection[str], every: Sequence[str] = FLOOR_PLANS) -> FloorPlans:
    """Divide the iTHOR floor plans without those of `benchmark`. Raises ValueError if the benchmark leaves none."""
    rest = [scene for scene in every if scene not in benchmark]
    held_out = tuple(rest[4::HELD_OUT_EVERY])
    if not held_out:
        raise ValueError("the benchmark uses all floor plans and leaves none for training; name fewer in splits.main.scenes")
    return FloorPlans(tuple(scene for scene in rest if scene not in held_out), held_out)
