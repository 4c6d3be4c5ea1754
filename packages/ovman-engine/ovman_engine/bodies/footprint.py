"""Exact distances between an upright capsule and oriented boxes, at a point and along a straight sweep.

An upright capsule is the set of points within a radius of a vertical segment, so it touches a box if the distance from the
segment to the box is below the radius. Plan coordinates are (x, z) in metres, in Unity's world frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman_engine.plan.floorplan import Box

SAMPLE_M = 0.05
"""Spacing of the samples of a sweep against a tilted box. A point obstacle is missed by at most SAMPLE_M**2 / (8 r), 1.6 mm for r
= 0.2 m. Sweeps against upright boxes are exact."""
UPRIGHT = 1 - 1e-6
"""Cosine above which an axis of a box counts as vertical: bodies that physics settled are never exactly upright."""


@dataclass(frozen=True)
class Boxes:
    """N boxes in columns. An upright box is a rectangle in plan times an interval of heights; a tilted box is neither."""

    centre: np.ndarray
    """(N, 3)"""
    half: np.ndarray
    """(N, 3)"""
    rotation: np.ndarray
    """(N, 3, 3) from box to world axes"""
    plan_axis: np.ndarray
    """(N, 2) unit vector (x, z) of the first horizontal axis; for a tilted box, of the box around it"""
    plan_half: np.ndarray
    """(N, 2) half extents along `plan_axis` and across it"""
    low: np.ndarray
    """(N,) lowest height"""
    high: np.ndarray
    """(N,) highest height"""
    tilted: np.ndarray
    """(N,) bool"""

    def __len__(self) -> int:
        """Return number of boxes."""
        return len(self.centre)

    @staticmethod
    def of(boxes: Sequence[Box]) -> Boxes:
        """Return the columns of `boxes`."""
        n = len(boxes)
        centre = np.array([b.centre for b in boxes], dtype=float).reshape(n, 3)
        half = np.array([b.half for b in boxes], dtype=float).reshape(n, 3)
        rotation = np.array([b.rotation for b in boxes], dtype=float).reshape(n, 3, 3)
        reach = np.einsum("nij,nj->ni", np.abs(rotation), half)
        vertical = np.abs(rotation[:, 1, :]).argmax(axis=1) if n else np.zeros(0, dtype=int)
        tilted = np.abs(rotation[np.arange(n), 1, vertical]) < UPRIGHT
        first, second = np.where(vertical == 0, 1, 0), np.where(vertical == 2, 1, 2)
        rows = np.arange(n)
        axis = rotation[rows, :, first][:, [0, 2]]
        axis = axis / np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-12)
        plan_half = np.stack([half[rows, first], half[rows, second]], axis=1)
        axis[tilted], plan_half[tilted] = [1.0, 0.0], reach[tilted][:, [0, 2]]
        return Boxes(centre, half, rotation, axis, plan_half, centre[:, 1] - reach[:, 1], centre[:, 1] + reach[:, 1], tilted)

    def take(self, index: np.ndarray) -> Boxes:
        """Return the boxes at `index` (integers or a mask)."""
        return Boxes(*(column[index] for column in self._columns()))

    def join(self, other: Boxes) -> Boxes:
        """Return these boxes followed by `other`."""
        return Boxes(*(np.concatenate(pair) for pair in zip(self._columns(), other._columns(), strict=True)))

    def _columns(self) -> tuple[np.ndarray, ...]:
        return (self.centre, self.half, self.rotation, self.plan_axis, self.plan_half, self.low, self.high, self.tilted)

    def _in_plan(self, points: np.ndarray, index: np.ndarray | slice) -> np.ndarray:
        """`points` (..., 2) in the plan frames of the boxes at `index`; broadcasts."""
        relative = points - self.centre[index][:, [0, 2]]
        axis = self.plan_axis[index]
        along = relative[..., 0] * axis[:, 0] + relative[..., 1] * axis[:, 1]
        across = relative[..., 1] * axis[:, 0] - relative[..., 0] * axis[:, 1]
        return np.stack([along, across], axis=-1)

    def _gap(self, low: float, high: float, index: np.ndarray | slice) -> np.ndarray:
        return np.maximum(np.maximum(self.low[index] - high, low - self.high[index]), 0.0)

    def distances(self, points: np.ndarray, low: float, high: float, within: float) -> np.ndarray:
        """Distances from the vertical segments [`low`, `high`] at `points` (M, 2) to all boxes: (M, N) metres.

        Distances below `within` are exact. For tilted boxes farther away, the result may be a lower bound that is above `within`.
        """
        local = np.abs(self._in_plan(points[:, None, :], slice(None))) - self.plan_half
        out = np.hypot(np.hypot(*np.moveaxis(np.maximum(local, 0.0), -1, 0)), self._gap(low, high, slice(None)))
        near, box = np.nonzero((out < within) & self.tilted)
        if len(near):
            out[near, box] = self._tilted(points[near], box, low, high)
        return out

    def sweeps(self, starts: np.ndarray, ends: np.ndarray, index: np.ndarray, low: float, high: float) -> np.ndarray:
        """Return the least distances (K,) metres between vertical segments that move straight and boxes.

        Segment k moves from `starts[k]` to `ends[k]`, and its box is `index[k]`.
        """
        a, b, half = self._in_plan(starts, index), self._in_plan(ends, index), self.plan_half[index]
        plan = np.minimum(_point_rectangle(a, half), _point_rectangle(b, half))
        along = b - a
        length2 = np.maximum((along**2).sum(axis=1), 1e-18)
        for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            corner = half * sign
            t = np.clip(((corner - a) * along).sum(axis=1) / length2, 0.0, 1.0)
            plan = np.minimum(plan, np.linalg.norm(a + t[:, None] * along - corner, axis=1))
        plan[_crosses(a, along, half)] = 0.0
        out = np.hypot(plan, self._gap(low, high, index))
        tilted = np.nonzero(self.tilted[index])[0]
        if len(tilted):
            longest = float(np.linalg.norm(ends[tilted] - starts[tilted], axis=1).max())
            steps = int(np.ceil(longest / SAMPLE_M)) + 1
            nearest = np.full(len(tilted), np.inf)
            for t in np.linspace(0.0, 1.0, steps):
                at = starts[tilted] + t * (ends[tilted] - starts[tilted])
                nearest = np.minimum(nearest, self._tilted(at, index[tilted], low, high))
            out[tilted] = nearest
        return out

    def _tilted(self, points: np.ndarray, index: np.ndarray, low: float, high: float) -> np.ndarray:
        """Distances from vertical segments to boxes of any rotation, pairwise: (K,) metres.

        The squared distance along the segment is convex and piecewise quadratic, with breaks where the segment crosses the planes
        of the faces. So its derivative is bracketed between two breaks, and linear there.
        """
        foot = np.stack([points[:, 0], np.full(len(points), low), points[:, 1]], axis=1)
        rotation, half = self.rotation[index], self.half[index]
        origin = np.einsum("kij,ki->kj", rotation, foot - self.centre[index])
        along = rotation[:, 1, :] * (high - low)
        safe = np.where(np.abs(along) < 1e-12, 1e-12, along)
        breaks = np.concatenate([(half - origin) / safe, (-half - origin) / safe], axis=1)
        t = np.sort(np.concatenate([np.clip(breaks, 0.0, 1.0), np.zeros((len(foot), 1)), np.ones((len(foot), 1))], axis=1))
        at = origin[:, None, :] + t[..., None] * along[:, None, :]
        outside = np.sign(at) * np.maximum(np.abs(at) - half[:, None, :], 0.0)
        slope = (outside * along[:, None, :]).sum(axis=2)
        last = np.maximum((slope <= 0).sum(axis=1) - 1, 0)
        following = np.minimum(last + 1, t.shape[1] - 1)
        rows = np.arange(len(foot))
        s0, s1, t0, t1 = slope[rows, last], slope[rows, following], t[rows, last], t[rows, following]
        best = np.where(s1 > s0, t0 - s0 * (t1 - t0) / np.where(s1 > s0, s1 - s0, 1.0), t0)
        nearest = origin + np.clip(best, t0, t1)[:, None] * along
        return np.linalg.norm(np.maximum(np.abs(nearest) - half, 0.0), axis=1)


def _point_rectangle(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.maximum(np.abs(points) - half, 0.0), axis=1)


def _crosses(start: np.ndarray, along: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Whether the plan segments meet the rectangles (slab test), pairwise: (K,) bool."""
    still = np.abs(along) < 1e-12
    safe = np.where(still, 1e-12, along)
    t0, t1 = (-half - start) / safe, (half - start) / safe
    enter, leave = np.minimum(t0, t1), np.maximum(t0, t1)
    inside = np.abs(start) <= half
    enter = np.where(still, np.where(inside, 0.0, 2.0), enter)
    leave = np.where(still, np.where(inside, 1.0, -1.0), leave)
    return np.maximum(enter.max(axis=1), 0.0) <= np.minimum(leave.min(axis=1), 1.0)
