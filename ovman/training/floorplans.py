"""The floor plans to learn from: none of them is the benchmark's."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from ovman.models.settings.benchmark import FLOOR_PLANS

HELD_OUT_EVERY = 9
"""One in so many of the floor plans is kept for the curves; kitchens, living rooms, bedrooms and bathrooms alike."""


@dataclass(frozen=True, slots=True)
class FloorPlans:
    """taught: the networks learn from these; held_out: the curves and every choice are made on these."""

    taught: tuple[str, ...]
    held_out: tuple[str, ...]


def floor_plans(benchmark: Collection[str], every: Sequence[str] = FLOOR_PLANS) -> FloorPlans:
    """The iTHOR floor plans without those of `benchmark`, divided. Raises ValueError if the benchmark leaves none."""
    rest = [scene for scene in every if scene not in benchmark]
    held_out = tuple(rest[4::HELD_OUT_EVERY])
    if not held_out:
        raise ValueError("the benchmark uses all floor plans: there is nothing to learn from")
    return FloorPlans(tuple(scene for scene in rest if scene not in held_out), held_out)
