"""Shortest paths of the agent on the floor: AI2-THOR's navigation mesh.

A navigation mesh is made before anything moves, and without movable objects, so paths lead through chairs. Plan coordinates are
(x, z) in metres, in Unity's world frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ovman_engine.bodies.passage import Obstacles

STEPS_M = (0.125, 0.0625)
"""Spacings of the search lattices; the finer one is used if the coarser has no path."""
NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1))
"""Steps between lattice points; the opposite steps are used as well."""
TIGHT_M = 0.02
"""Spacing of the points between which a path is straightened."""
TIGHTENED = 3
"""How often a path is straightened."""
SNAP_M = 0.2
"""How far beside the mesh a point may be; AI2-THOR's value."""
ROUNDING_M = 1e-6


@dataclass(frozen=True)
class Floor:
    """Where the agent's centre may be: inside a rectangle, clear of obstacles."""

    obstacles: Obstacles
    low: np.ndarray
    """(2,) lower corner of the rectangle"""
    high: np.ndarray

    def free(self, points: np.ndarray) -> np.ndarray:
        """(M,) bool: which of the points (M, 2) are on the floor."""
        inside = ((points >= self.low - ROUNDING_M) & (points <= self.high + ROUNDING_M)).all(axis=1)
        reach = self.obstacles.reach
        clear = self.obstacles.distances(points, float(reach.max(initial=0.0)) + ROUNDING_M) >= reach - ROUNDING_M
        return np.asarray(inside & clear.all(axis=1))

    def joined(self, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """(M,) bool: between which of the points (M, 2) and (M, 2), all on the floor, the straight way is free."""
        if not len(starts):
            return np.zeros(0, dtype=bool)
        reach, length = self.obstacles.reach, np.linalg.norm(ends - starts, axis=1)
        within = float(reach.max(initial=0.0)) + float(length.max()) + ROUNDING_M
        # A box within reach of a segment is near its middle by half of its length more.
        near = self.obstacles.distances((starts + ends) / 2, within) < reach + length[:, None] / 2
        pair, box = np.nonzero(near)
        gap = self.obstacles.boxes.sweeps(starts[pair], ends[pair], box, self.obstacles.low, self.obstacles.high)
        found = np.ones(len(starts), dtype=bool)
        found[pair[gap < reach[box] - ROUNDING_M]] = False
        return found

    def nearest(self, point: np.ndarray, within_m: float) -> np.ndarray | None:
        """Return the point of the floor nearest to `point` (2,), to the centimetre; None if none is within the distance."""
        if self.free(point[None])[0]:
            return point
        count = int(np.ceil(within_m / 0.01))
        offsets = np.stack(np.meshgrid(*[np.arange(-count, count + 1) * 0.01] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
        away = np.linalg.norm(offsets, axis=1)
        order = np.argsort(away, kind="stable")
        around = point + offsets[order[away[order] <= within_m]]
        found = np.flatnonzero(self.free(around))
        return around[found[0]] if len(found) else None


def shortest(floor: Floor, start: np.ndarray, target: np.ndarray) -> np.ndarray | None:
    """Corners (C, 2) of a taut path on the floor from `start` to `target` (2,), both on it; None if no path exists.

    The path is found on a lattice and straightened, so its length exceeds the shortest by a few centimetres at most.
    """
    if np.linalg.norm(target - start) < ROUNDING_M:
        return start[None]
    if floor.joined(start[None], target[None])[0]:
        return np.stack([start, target])
    for step in STEPS_M:
        found = _on_lattice(floor, start, target, step)
        if found is not None:
            for _ in range(TIGHTENED):
                found = _pulled(floor, _dense(found))
            return found
    return None


def length(corners: np.ndarray) -> float:
    """Length of a path (C, 2) or (C, 3), metres."""
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())


def _on_lattice(floor: Floor, start: np.ndarray, target: np.ndarray, step: float) -> np.ndarray | None:
    """Return the shortest path on a lattice through `start`, then to `target`: corners (C, 2), or None."""
    first, last = np.ceil((floor.low - start) / step).astype(int), np.floor((floor.high - start) / step).astype(int)
    first, last = np.minimum(first, 0), np.maximum(last, 0)
    shape = last - first + 1
    cells = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij"), axis=-1)
    points = start + step * cells.reshape(-1, 2)
    free = floor.free(points).reshape(shape)
    free[tuple(-first)] = True
    number = np.arange(free.size).reshape(shape)
    edges = []
    for i, j in NEIGHBOURS:
        a = number[: shape[0] - i, max(-j, 0) : shape[1] - max(j, 0)]
        b = number[i:, max(j, 0) : shape[1] + min(j, 0)]
        both = free.ravel()[a] & free.ravel()[b]
        edges.append(np.stack([a[both], b[both]], axis=1))
    goal = free.size
    close = np.flatnonzero(free.ravel() & (np.linalg.norm(points - target, axis=1) < 2 * step))
    edges.append(np.stack([close, np.full(len(close), goal)], axis=1))
    edge, points = np.concatenate(edges), np.concatenate([points, target[None]])
    edge = edge[floor.joined(points[edge[:, 0]], points[edge[:, 1]])]
    cost = np.linalg.norm(points[edge[:, 0]] - points[edge[:, 1]], axis=1)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    graph = coo_array((cost, (edge[:, 0], edge[:, 1])), shape=(goal + 1, goal + 1)).tocsr()
    own = int(number[tuple(-first)])
    far, before = dijkstra(graph, directed=False, indices=own, return_predecessors=True)
    if not np.isfinite(far[goal]):
        return None
    way = [goal]
    while way[-1] != own:
        way.append(int(before[way[-1]]))
    return points[way[::-1]]


def _dense(corners: np.ndarray) -> np.ndarray:
    """Return the same path with corners at most `TIGHT_M` apart."""
    pieces = []
    for a, b in zip(corners[:-1], corners[1:], strict=True):
        count = max(int(np.ceil(np.linalg.norm(b - a) / TIGHT_M)), 1)
        pieces.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate([*pieces, corners[-1:]])


def _pulled(floor: Floor, corners: np.ndarray) -> np.ndarray:
    """Return the path from each corner straight to the last corner that can be reached."""
    kept, here = [corners[0]], 0
    while here < len(corners) - 1:
        on = np.flatnonzero(
            floor.joined(np.repeat(corners[here : here + 1], len(corners) - here - 1, axis=0), corners[here + 1 :])
        )
        here += 1 + (int(on[-1]) if len(on) else 0)
        kept.append(corners[here])
    return np.array(kept)
