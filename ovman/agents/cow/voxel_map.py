"""CoW's map: what is known of the floor plane, voxel by voxel, and where the category may be.

The heights of the voxels are collapsed onto the layer of the floor: whatever is above it, below the ceiling, is an obstacle.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from scipy import ndimage

from ovman.agents.cow.scan import Scan
from ovman.agents.cow.settings import Cow

Cell = tuple[int, int]

BLOCK = 64
"""The arrays grow by so many voxels at a time."""
EIGHT = ndimage.generate_binary_structure(2, 2)


class VoxelState(IntEnum):
    """What a voxel of the floor plane is. FRONTIER is free, too: it borders on what is unknown."""

    UNKNOWN = 0
    FREE = 1
    FRONTIER = 2
    OCCUPIED = 3


class VoxelMap:
    """Voxels (i, j) of x and z, counted from the start of the episode and negative behind it.

    regions: the voxels that may be the category (regions of interest), in the order of their distance to the agent when the last
    of them was found.
    """

    def __init__(self, constants: Cow) -> None:
        self._constants = constants
        self._origin = np.full(2, -BLOCK // 2)
        self._state = np.zeros((BLOCK, BLOCK), np.uint8)
        self._relevance = np.zeros((BLOCK, BLOCK), np.float32)
        self._height = np.zeros((BLOCK, BLOCK), np.float32)
        self._interest = np.zeros((BLOCK, BLOCK), np.int32)
        self._visited = np.zeros((BLOCK, BLOCK), bool)
        self.regions: tuple[Cell, ...] = ()

    @property
    def state(self) -> np.ndarray:
        """(A, B) uint8 of `VoxelState`; element (0, 0) is the cell `origin`."""
        return self._state

    @property
    def origin(self) -> Cell:
        """The cell of the first element of `state`."""
        return int(self._origin[0]), int(self._origin[1])

    def at(self, cell: Cell) -> VoxelState:
        """What is known of a cell."""
        i, j = cell[0] - self._origin[0], cell[1] - self._origin[1]
        inside = 0 <= i < self._state.shape[0] and 0 <= j < self._state.shape[1]
        return VoxelState(int(self._state[i, j])) if inside else VoxelState.UNKNOWN

    def states(self, cells: np.ndarray) -> np.ndarray:
        """(N,) uint8 of `VoxelState` of cells (N, 2)."""
        inner = cells - self._origin
        inside = ((inner >= 0) & (inner < self._state.shape)).all(axis=1)
        found = np.zeros(len(cells), np.uint8)
        found[inside] = self._state[inner[inside, 0], inner[inside, 1]]
        return found

    def interest(self, cell: Cell) -> tuple[float, float]:
        """Greatest relevance that was seen in a cell, and its height in metres above the camera."""
        i, j = cell[0] - self._origin[0], cell[1] - self._origin[1]
        return float(self._relevance[i, j]), float(self._height[i, j])

    def visit(self, cell: Cell) -> None:
        """Marks a frontier and its neighbourhood as visited: they are no targets any more."""
        reach = self._constants.visited_voxels // 2
        i, j = cell[0] - self._origin[0], cell[1] - self._origin[1]
        self._visited[max(i - reach, 0) : i + reach + 1, max(j - reach, 0) : j + reach + 1] = True

    def visited(self, cell: Cell) -> bool:
        """Whether a frontier was marked as visited."""
        return bool(self._visited[cell[0] - self._origin[0], cell[1] - self._origin[1]])

    def update(self, seen: Scan, agent: Cell) -> None:
        """Takes what was seen into the map. Later rules overwrite earlier ones, in the published order."""
        self._cover(seen, agent)
        state = self._state
        i, j = seen.cells.T
        # Tens of thousands of points: one index each is faster than two.
        element = (i - self._origin[0]) * state.shape[1] + (j - self._origin[1])
        state[state == VoxelState.FRONTIER] = VoxelState.FREE
        state.ravel()[element[seen.floor]] = VoxelState.FREE
        self._pad(seen)
        occupied = np.zeros(state.shape, bool)
        occupied.ravel()[element[~seen.floor]] = True
        # The body is wider than a voxel: the four neighbours of an obstacle are no place for it.
        state[_with_neighbours(occupied, outside=False)] = VoxelState.OCCUPIED
        beside_unknown = _with_neighbours(state == VoxelState.UNKNOWN, outside=True)
        state[(state == VoxelState.FREE) & beside_unknown] = VoxelState.FRONTIER
        self._take_interest(seen, element, occupied, agent)

    def _pad(self, seen: Scan) -> None:
        """Free, where nothing is known, on the rays to the nearest points below the camera: the floor that it does not see."""
        along = seen.blind - seen.origin
        if not len(along):
            return
        length = np.hypot(along[:, 0], along[:, 1])
        steps = np.arange(0.0, length.max() + self._constants.ray_step_voxels, self._constants.ray_step_voxels)
        share = np.minimum(steps[None, :] / np.maximum(length, 1e-9)[:, None], 1.0)
        cells = np.rint(seen.origin + share[..., None] * along[:, None, :]).astype(np.int32).reshape(-1, 2)
        i, j = cells[self.states(cells) == VoxelState.UNKNOWN].T - self._origin[:, None]
        self._state[i, j] = VoxelState.FREE

    def _take_interest(self, seen: Scan, element: np.ndarray, occupied: np.ndarray, agent: Cell) -> None:
        """element: (N,) of the flattened arrays, where each point is."""
        counts = np.flatnonzero((seen.relevance > 0) & ~seen.floor)
        if len(counts):
            order = counts[np.argsort(seen.relevance[counts], kind="stable")]
            order = order[seen.relevance[order] > self._relevance.ravel()[element[order]]]
            for known, found in ((self._relevance, seen.relevance), (self._height, seen.height)):
                known.ravel()[element[order]] = found[order]
            relevant = np.unique(element[counts[seen.relevance[counts] > self._constants.relevant]])
            self._interest.ravel()[relevant] += 1
        here = np.argwhere(occupied & (self._interest > 0)) + self._origin
        if len(here):
            nearest = here[np.argmin(np.hypot(*(here - np.array(agent)).T))]
            region = (int(nearest[0]), int(nearest[1]))
            if region not in self.regions:
                self.regions = tuple(
                    sorted({*self.regions, region}, key=lambda c: (np.hypot(c[0] - agent[0], c[1] - agent[1]), c))
                )

    def _cover(self, seen: Scan, agent: Cell) -> None:
        """Grows the arrays to what was seen, with a margin for the neighbours."""
        corners = [np.array(agent)[None], np.rint(seen.origin).astype(int)[None]]
        if len(seen.cells):
            corners += [seen.cells.min(axis=0)[None], seen.cells.max(axis=0)[None]]
        points = np.concatenate(corners)
        before = self._origin - (points.min(axis=0) - 4)
        after = points.max(axis=0) + 4 - (self._origin + self._state.shape) + 1
        blocks = [
            (max(-(-int(b) // BLOCK), 0) * BLOCK, max(-(-int(a) // BLOCK), 0) * BLOCK) for b, a in zip(before, after, strict=True)
        ]
        if any(b or a for b, a in blocks):
            self._origin = self._origin - np.array([b for b, _ in blocks])
            for name in ("_state", "_relevance", "_height", "_interest", "_visited"):
                setattr(self, name, np.pad(getattr(self, name), blocks))


def _with_neighbours(chosen: np.ndarray, outside: bool) -> np.ndarray:
    """(A, B) bool: the chosen cells and the four neighbours of each. outside: whether what is not in the array is chosen."""
    padded = np.pad(chosen, 1, constant_values=outside)
    grown: np.ndarray = chosen | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]
    return grown
