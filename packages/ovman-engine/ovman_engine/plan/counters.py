"""The true outline of counters within their bounding boxes, and the stoves between them.

Recorded counters are thin slabs with one axis-aligned box each, even if they run around a corner. The box touches the counter on
all four sides, so an L- or U-shaped counter is a strip along one side with legs across to the opposite side. Of all such layouts,
the one is chosen that covers what stands under and on the counter, leaves the agent's start free, and covers little else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ovman_engine.plan.floorplan import FloorPlan, SimObject

CELL_M = 0.05
"""Resolution of the evidence, and step of strip depths and leg positions."""
WHOLE_M = 0.95
"""A narrower counter is one rectangle: two runs of usual depth do not fit."""
ISLAND_M = 1.3
"""A counter without base units is one rectangle up to this width: an island or a bar."""
DEPTHS_M = np.round(np.arange(0.45, 0.91, CELL_M), 3)
"""Possible depths of a run."""
BODY_M = 0.2
"""Radius of the agent, whose start was free."""
UNDER_M = 0.5
"""A base unit is at most this far below the slab."""
UNSUPPORTED = 0.3
"""Cost of covering a cell without evidence, relative to a cell with evidence."""
AGAINST = 2.0
"""Cost of covering a cell in which a tall object stands."""
BASES = frozenset({"Cabinet", "Drawer"})
CARRIERS = BASES | {"Sink", "SinkBasin", "Faucet"}
TALL = frozenset({"Fridge", "GarbageCan", "Chair", "Stool", "Toilet", "Bathtub", "ShelvingUnit", "DiningTable"})
STOVE_MARGIN_M = 0.07


class Rect(NamedTuple):
    """A rectangle in the floor plane, metres, world frame."""

    x0: float
    z0: float
    x1: float
    z1: float

    def overlap(self, other: Rect) -> Rect | None:
        """Return the common rectangle, None if it has no area."""
        common = Rect(max(self.x0, other.x0), max(self.z0, other.z0), min(self.x1, other.x1), min(self.z1, other.z1))
        return common if common.x1 > common.x0 and common.z1 > common.z0 else None

    def holds(self, x: float, z: float, margin: float = 0.0) -> bool:
        """Whether the point (x, z) is inside, or at most `margin` metres outside."""
        return self.x0 - margin < x < self.x1 + margin and self.z0 - margin < z < self.z1 + margin


@dataclass(frozen=True)
class Stove:
    """A stove under recorded burners. Floor plans record burners and knobs, not the stove."""

    rect: Rect
    top: float
    """Height of the hob, metres."""
    grate: float
    """Height of the burners, metres; pots wider than a burner stand on several"""
    quarter: int
    """Quarter turns about y from +z to its front."""
    burner: SimObject
    """The first burner, which gives the stove its name and finish."""


_RUNS: WeakKeyDictionary[FloorPlan, dict[str, tuple[Rect, ...]]] = WeakKeyDictionary()


def footprint(obj: SimObject) -> Rect:
    """Return the axis-aligned box around an object, in plan."""
    low, high = obj.box.bounds()
    return Rect(float(low[0]), float(low[2]), float(high[0]), float(high[2]))


def runs(plan: FloorPlan, counter: SimObject) -> tuple[Rect, ...]:
    """Return at most three rectangles that `counter` covers within its bounding box.

    They do not overlap; metres, world frame.
    """
    found = _RUNS.setdefault(plan, {})
    if counter.object_id not in found:
        found[counter.object_id] = _runs(plan, counter)
    return found[counter.object_id]


def carriers(plan: FloorPlan, counter: SimObject) -> list[SimObject]:
    """Return base units under the slab, or set into it."""
    low, high = counter.box.bounds()
    box = footprint(counter)
    found = []
    for other in plan.objects:
        if other.type in CARRIERS:
            other_low, other_high = other.box.bounds()
            common = box.overlap(footprint(other))
            level = low[1] - UNDER_M < other_high[1] and other_low[1] < high[1] + 0.02 and other_low[1] > plan.floor_y - 0.3
            if common and level:
                found.append(other)
    return found


def _runs(plan: FloorPlan, counter: SimObject) -> tuple[Rect, ...]:
    box = footprint(counter)
    island = not any(o.type in BASES for o in carriers(plan, counter))
    if min(box.x1 - box.x0, box.z1 - box.z0) <= (ISLAND_M if island else WHOLE_M) and not box.holds(
        plan.start[0], plan.start[2], BODY_M
    ):
        return (box,)
    support, against = _evidence(plan, counter, box)
    worth = support - UNSUPPORTED * (support == 0) - AGAINST * against + support
    total = np.zeros((worth.shape[0] + 1, worth.shape[1] + 1))
    total[1:, 1:] = worth.cumsum(axis=0).cumsum(axis=1)
    layouts = _layouts(box)
    x0, z0, x1, z1 = np.moveaxis(layouts, -1, 0)
    within_x = (x0 - BODY_M < plan.start[0]) & (plan.start[0] < x1 + BODY_M)
    free = ~(within_x & (z0 - BODY_M < plan.start[2]) & (plan.start[2] < z1 + BODY_M)).any(axis=1)
    scores = np.where(free, _scores(total, box, layouts), -np.inf)
    # the first of equally good layouts; only a layout that beats all earlier ones can be it
    ahead = np.maximum.accumulate(np.concatenate([[-np.inf], scores[:-1]]))
    best, score = None, -np.inf
    for i in np.flatnonzero(scores > ahead):
        if scores[i] > score + 1e-9:
            best, score = i, scores[i]
    if best is None:
        return (box,)
    return tuple(Rect(*map(float, rect)) for rect in layouts[best] if not np.isnan(rect[0]))


def _scores(total: np.ndarray, box: Rect, layouts: np.ndarray) -> np.ndarray:
    """Return sums (L,) over the cells of layouts (L, 3, 4).

    The running sums `total` begin with a row and a column of zeros.
    """
    there = ~np.isnan(layouts[..., 0])
    edges = np.where(there[..., None], layouts, 0.0)
    first, last = [], []
    for low, start, end, count in (
        (box.x0, edges[..., 0], edges[..., 2], total.shape[0] - 1),
        (box.z0, edges[..., 1], edges[..., 3], total.shape[1] - 1),
    ):
        first.append(np.clip(np.floor((start - low) / CELL_M + 0.25), 0, count - 1).astype(int))
        last.append(np.minimum(np.maximum(np.ceil((end - low) / CELL_M - 0.25).astype(int), first[-1] + 1), count))
    (i0, j0), (i1, j1) = first, last
    sums = total[i1, j1] - total[i0, j1] - total[i1, j0] + total[i0, j0]
    return np.where(there, sums, 0.0).sum(axis=1)


def _evidence(plan: FloorPlan, counter: SimObject, box: Rect) -> tuple[np.ndarray, np.ndarray]:
    """Two grids over `box`: the evidence for and against a counter in each cell."""
    shape = tuple(max(1, int(np.ceil((high - low) / CELL_M))) for low, high in ((box.x0, box.x1), (box.z0, box.z1)))
    support, against = np.zeros(shape), np.zeros(shape)
    for other in carriers(plan, counter):
        common = box.overlap(footprint(other))
        if common:
            support[_cells(box, common, shape)] = 1.0
    for other in plan.objects:
        common = box.overlap(footprint(other))
        if common is None or other is counter:
            continue
        if counter.object_id in other.parents:
            support[_cells(box, common, shape)] = 1.0
        elif other.type in TALL and other.box.bounds()[0][1] < plan.floor_y + 0.2:
            against[_cells(box, common, shape)] = 1.0
    return support, against


def _cells(box: Rect, rect: Rect, shape: tuple[int, ...]) -> tuple[slice, slice]:
    spans = []
    for low, first, last, count in ((box.x0, rect.x0, rect.x1, shape[0]), (box.z0, rect.z0, rect.z1, shape[1])):
        start = min(max(math.floor((first - low) / CELL_M + 0.25), 0), count - 1)
        spans.append(slice(start, min(max(math.ceil((last - low) / CELL_M - 0.25), start + 1), count)))
    return spans[0], spans[1]


def _legs(long: float) -> np.ndarray:
    """(K, 4): intervals (a, b, c, d) of legs along a strip of this length; NaN for c and d with one leg."""
    legs = []
    for wide in DEPTHS_M[long - 0.2 > DEPTHS_M]:
        starts = np.append(np.arange(0.0, long - wide, 2 * CELL_M), long - wide)
        legs.append(np.stack([starts, starts + wide, *np.full((2, len(starts)), np.nan)], axis=1))
        if 2 * wide < long - 0.3:
            legs.append(np.array([[0.0, wide, long - wide, long]]))
    return np.concatenate(legs) if legs else np.zeros((0, 4))


def _layouts(box: Rect) -> np.ndarray:
    """(L, 3, 4) rectangles: the whole box, and every strip along a side with one leg anywhere or two legs at its ends.

    Missing rectangles are NaN.
    """
    found = [np.array([[box, *np.full((2, 4), np.nan)]])]
    for side in range(4):  # low z, low x, high z, high x
        wide, deep = (box.x1 - box.x0, box.z1 - box.z0)[:: 1 if side % 2 == 0 else -1]
        depths, legs = DEPTHS_M[deep - 0.2 > DEPTHS_M], _legs(wide)
        a, b, c, d = np.tile(legs, (len(depths), 1)).T
        depth = np.repeat(depths, len(legs))
        along = box.x0 if side % 2 == 0 else box.z0
        whole = (box.x0, box.x1) if side % 2 == 0 else (box.z0, box.z1)
        near, far = (box.z0, box.z1) if side % 2 == 0 else (box.x0, box.x1)
        strip, rest = ((near, near + depth), (near + depth, far)) if side < 2 else ((far - depth, far), (near, far - depth))
        layouts = np.empty((len(a), 3, 4))
        for k, (start, end, across) in enumerate(((*whole, strip), (along + a, along + b, rest), (along + c, along + d, rest))):
            sides = (start, across[0], end, across[1]) if side % 2 == 0 else (across[0], start, across[1], end)
            for column, value in enumerate(sides):
                layouts[:, k, column] = value
        layouts[np.isnan(c), 2] = np.nan
        found.append(layouts)
    return np.concatenate(found)


def without(rect: Rect, holes: tuple[Rect, ...]) -> tuple[Rect, ...]:
    """`rect` without `holes`, as rectangles that do not overlap."""
    pieces = [rect]
    for hole in holes:
        rest = []
        for piece in pieces:
            cut = piece.overlap(hole)
            if cut is None:
                rest.append(piece)
                continue
            rest += [
                Rect(piece.x0, piece.z0, piece.x1, cut.z0),
                Rect(piece.x0, cut.z1, piece.x1, piece.z1),
                Rect(piece.x0, cut.z0, cut.x0, cut.z1),
                Rect(cut.x1, cut.z0, piece.x1, cut.z1),
            ]
        pieces = [p for p in rest if p.x1 - p.x0 > 1e-3 and p.z1 - p.z0 > 1e-3]
    return tuple(pieces)


def stoves(plan: FloorPlan) -> tuple[Stove, ...]:
    """Stoves under burners that are not on a counter. Burners less than 0.5 m apart share one."""
    tops = [o for o in plan.objects if o.type == "CounterTop"]
    slabs = [r for o in tops for r in runs(plan, o)]
    burners = sorted((o for o in plan.objects if o.type == "StoveBurner"), key=lambda o: o.object_id)
    groups: list[list[SimObject]] = []
    for burner in burners:
        for group in groups:
            if any(np.linalg.norm((burner.box.centre - other.box.centre)[[0, 2]]) < 0.5 for other in group):
                group.append(burner)
                break
        else:
            groups.append([burner])
    found = []
    for group in groups:
        prints = [footprint(o) for o in group]
        rect = Rect(min(p.x0 for p in prints), min(p.z0 for p in prints), max(p.x1 for p in prints), max(p.z1 for p in prints))
        if any(r.holds((rect.x0 + rect.x1) / 2, (rect.z0 + rect.z1) / 2, 0.05) for r in slabs):
            continue
        found.append(_stove(plan, group, rect, slabs))
    return tuple(found)


def _stove(plan: FloorPlan, group: list[SimObject], rect: Rect, slabs: list[Rect]) -> Stove:
    """Return a stove around the burners that keeps clear of the counters beside it and faces the agent's start."""
    sides = [rect.x0 - STOVE_MARGIN_M, rect.z0 - STOVE_MARGIN_M, rect.x1 + STOVE_MARGIN_M, rect.z1 + STOVE_MARGIN_M]
    middle = ((rect.x0 + rect.x1) / 2, (rect.z0 + rect.z1) / 2)
    beside_x = beside_z = 0
    for slab in slabs:
        if slab.z0 < middle[1] < slab.z1:
            beside_x += 1
            if slab.x1 <= middle[0]:
                sides[0] = max(sides[0], slab.x1)
            else:
                sides[2] = min(sides[2], slab.x0)
        if slab.x0 < middle[0] < slab.x1:
            beside_z += 1
            if slab.z1 <= middle[1]:
                sides[1] = max(sides[1], slab.z1)
            else:
                sides[3] = min(sides[3], slab.z0)
    to_start = plan.start[[0, 2]] - middle
    along_z = beside_x > beside_z if beside_x != beside_z else abs(to_start[1]) > abs(to_start[0])
    quarter = (0 if to_start[1] > 0 else 2) if along_z else (1 if to_start[0] > 0 else 3)
    top = min(float(o.box.bounds()[0][1]) for o in group)
    grate = min(float(o.box.bounds()[1][1]) for o in group)
    return Stove(Rect(*(float(s) for s in sides)), top, grate, quarter, group[0])
