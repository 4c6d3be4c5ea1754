"""The floor plans and homes of the training data, none of which the benchmark uses."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

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


def home_names(assets: str, count: int) -> tuple[str, ...]:
    """Return the names of homes for training: "home-train-0" is drawn from the seed 0 with the assets of train."""
    return tuple(f"home-{assets}-{seed}" for seed in range(count))


def load_place(name: str) -> str | dict[str, Any]:
    """Return what a Controller loads: for a name of `home_names` a house of one or two rooms, other names as they are."""
    kind, *drawn = name.split("-")
    if kind != "home":
        return name
    from ovman.homes.generate import draw

    assets, seed = drawn
    return draw(int(seed), 1 + int(seed) % 2, assets).house
