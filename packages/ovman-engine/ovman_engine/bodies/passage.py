"""What the agent's capsule hits on a straight move, and which lattice positions moves reach.

Both are computed from the same boxes, so a position is reachable exactly if moves reach it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ovman_engine.bodies.footprint import Boxes

DEEPER_M = 1e-6
"""How much deeper a move may take the agent into a body that it overlaps already: rounding."""
PORTION = 8192
"""Number of positions that are measured at a time."""
OVERHANG_M = 0.04
"""An agent may be put where its capsule overlaps a box by this much: recorded boxes reach beyond the meshes with which AI2-THOR's
agents collide. Moves keep clear of the whole box, because most boxes reach less far."""
ON_EDGE = 1e-9
"""A position this far beyond an edge counts as on it: rounding."""


@dataclass(frozen=True)
class Obstacles:
    """Possible obstacles of a capsule whose axis is the vertical segment from `low` to `high` (heights, metres)."""

    boxes: Boxes
    reach: np.ndarray
    """(N,) least distance of the axis from each box, metres"""
    radius: float
    """Radius of the capsule alone, metres"""
    low: float
    high: float

    def take(self, index: np.ndarray) -> Obstacles:
        """Return the obstacles at `index` (integers or a mask)."""
        return Obstacles(self.boxes.take(index), self.reach[index], self.radius, self.low, self.high)

    def distances(self, points: np.ndarray, within: float) -> np.ndarray:
        """Distances from the axis at `points` (M, 2) to all boxes: (M, N) metres, exact below `within`."""
        return self.boxes.distances(points, self.low, self.high, within)

    def overlapping(self, point: np.ndarray) -> np.ndarray:
        """(N,) bool: which boxes the capsule at `point` (2,) overlaps."""
        return self.distances(point[None], self.radius)[0] < np.minimum(self.reach, self.radius)


def heading(yaw_deg: float) -> np.ndarray:
    """Return unit vector (x, z) of a yaw, exact along the axes of the world, so that a walk stays on its lattice."""
    if yaw_deg % 90 == 0:
        return np.array([(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][int(yaw_deg // 90) % 4])
    return np.array([math.sin(math.radians(yaw_deg)), math.cos(math.radians(yaw_deg))])


def first_hit(obstacles: Obstacles, start: np.ndarray, end: np.ndarray) -> int | None:
    """Index of the box that blocks the straight move from `start` to `end`, (2,) each, in plan; None if the way is free.

    A box that the capsule overlaps at the start blocks only moves that lead deeper into it. If start and end are equal, the
    result is a box that the capsule overlaps there by more than OVERHANG_M.
    """
    length = float(np.linalg.norm(end - start))
    at_start = obstacles.distances(start[None], float(obstacles.reach.max(initial=0.0)) + length)[0]
    if length == 0.0:
        hit = np.nonzero(at_start < np.minimum(obstacles.reach, obstacles.radius) - OVERHANG_M)[0]
        return int(hit[at_start[hit].argmin()]) if len(hit) else None
    near = np.nonzero(at_start < obstacles.reach + length)[0]
    if not len(near):
        return None
    starts, ends = np.tile(start, (len(near), 1)), np.tile(end, (len(near), 1))
    nearest = obstacles.boxes.sweeps(starts, ends, near, obstacles.low, obstacles.high)
    hit = near[nearest < np.minimum(obstacles.reach[near], at_start[near] - DEEPER_M)]
    return int(hit[at_start[hit].argmin()]) if len(hit) else None


def reachable(
    obstacles: Obstacles, here: np.ndarray, low: np.ndarray, high: np.ndarray, step_m: float, axes: np.ndarray
) -> np.ndarray:
    """Positions `here` + step_m * (i, j) @ `axes` within [`low`, `high`] (2,) that unblocked moves along the axes reach: (N, 2).

    The rows of `axes` (2, 2) are unit vectors in plan. Boxes that overlap the capsule at `here` block nothing. `here` comes
    first, the others in the order of i, then j.
    """
    if ((here < low - step_m) | (here > high + step_m)).any():
        return here[None]
    boxes, most = obstacles.boxes, float(obstacles.reach.max(initial=0.0))
    level = (boxes.low < obstacles.high + most) & (boxes.high > obstacles.low - most) & (obstacles.reach > 0)
    obstacles = obstacles.take(level & ~obstacles.overlapping(here))
    corners = np.array([(x, z) for x in (low[0], high[0]) for z in (low[1], high[1])])
    reached = (corners - here) @ axes.T / step_m
    first = np.minimum(np.ceil(reached.min(axis=0) - ON_EDGE).astype(int), 0)
    last = np.maximum(np.floor(reached.max(axis=0) + ON_EDGE).astype(int), 0)
    cells = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij"), axis=-1)
    number = np.arange(cells.shape[0] * cells.shape[1]).reshape(cells.shape[:2])
    points = (here + step_m * (cells @ axes)).reshape(-1, 2)
    inside = ((points >= low - ON_EDGE) & (points <= high + ON_EDGE)).all(axis=1)
    clear, near = _surroundings(obstacles, points, step_m)
    free = inside & clear
    label = _components(obstacles, points, number, near, free)
    own = int(number[tuple(-first)])
    seen, queue, entered = {own}, [own], set()
    while queue:
        index = queue.pop(0)
        if free[index]:
            if label[index] not in entered:
                entered.add(label[index])
                seen.update(np.nonzero((label == label[index]) & free)[0].tolist())
            continue
        for target in _beside(number, index):
            if target not in seen and inside[target] and first_hit(obstacles, points[index], points[target]) is None:
                seen.add(target)
                queue.append(target)
    return points[[own, *sorted(seen - {own})]]


def _beside(number: np.ndarray, index: int) -> list[int]:
    i, j = divmod(index, number.shape[1])
    around = ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))
    return [int(number[a, b]) for a, b in around if 0 <= a < number.shape[0] and 0 <= b < number.shape[1]]


def _surroundings(obstacles: Obstacles, points: np.ndarray, step_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return whether the capsule is free at the points (M, 2), and which boxes a move of `step_m` from or to them may hit.

    (M,) bool and (M, N) bool, eight boxes a byte. Points are processed in portions: fine grids have a million of them.
    """
    most = float(obstacles.reach.max(initial=0.0)) + step_m
    clear, near = np.ones(len(points), dtype=bool), np.empty((len(points), -(-len(obstacles.reach) // 8)), dtype=np.uint8)
    for start in range(0, len(points), PORTION):
        clearance = obstacles.distances(points[start : start + PORTION], most)
        clear[start : start + PORTION] = (clearance >= obstacles.reach).all(axis=1)
        # A move stays farther from a box than half of what the clearances of its ends leave beyond its length.
        near[start : start + PORTION] = np.packbits(clearance < obstacles.reach + step_m / 2, axis=1)
    return clear, near


def _components(obstacles: Obstacles, points: np.ndarray, number: np.ndarray, near: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(N,) int: label of each point's component, joined by unblocked moves between free neighbours."""
    along_x = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    along_z = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    edges = np.concatenate([along_x, along_z])
    edges = edges[free[edges].all(axis=1)]
    found = [
        np.stack(np.unpackbits(near[some[:, 0]] | near[some[:, 1]], axis=1, count=len(obstacles.reach)).nonzero())
        + np.array([[start], [0]])
        for start, some in ((start, edges[start : start + PORTION]) for start in range(0, len(edges), PORTION))
    ]
    edge, box = np.concatenate([np.empty((2, 0), dtype=np.int64), *found], axis=1)
    if len(edge):
        a, b = points[edges[edge, 0]], points[edges[edge, 1]]
        hit = obstacles.boxes.sweeps(a, b, box, obstacles.low, obstacles.high) < obstacles.reach[box]
        edges = np.delete(edges, np.unique(edge[hit]), axis=0)
    return joined(len(points), edges)


def joined(count: int, edges: np.ndarray) -> np.ndarray:
    """(count,) int: the least number in each number's component, where edges (E, 2) join the numbers 0 to count - 1.

    SciPy's sparse matrices do the same, and their import takes a fifth of an engine's start.
    """
    label = np.arange(count)
    while True:
        ends = label[edges]
        ends = ends[ends[:, 0] != ends[:, 1]]
        if not len(ends):
            return label
        np.minimum.at(label, ends.max(axis=1), ends.min(axis=1))
        while (label != label[label]).any():
            label = label[label]
