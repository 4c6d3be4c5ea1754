"""What CoW knows of the home: its believed pose, the points of the current view, and the map of voxels that they fill."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

import numpy as np
from scipy import ndimage

from ovman.agents.cow import Cow
from ovman.agents.interface import Action


@dataclass(frozen=True, slots=True)
class Pose:
    """A believed position and heading in the frame of the episode's start; x, z in metres, yaw in degrees in [0, 360)."""

    x: float = 0.0
    z: float = 0.0
    yaw_deg: float = 0.0

    def after(self, action: Action, step_m: float, turn_deg: float) -> Pose:
        """Return the pose after `action` without error; unchanged for an action that is not a motion."""
        if action is Action.MOVE_AHEAD:
            yaw = math.radians(self.yaw_deg)
            return Pose(self.x + step_m * math.sin(yaw), self.z + step_m * math.cos(yaw), self.yaw_deg)
        if action is Action.ROTATE_RIGHT:
            return Pose(self.x, self.z, (self.yaw_deg + turn_deg) % 360.0)
        if action is Action.ROTATE_LEFT:
            return Pose(self.x, self.z, (self.yaw_deg - turn_deg) % 360.0)
        return self

    def cell(self, voxel_m: float) -> tuple[int, int]:
        """Return the voxel of the agent, truncated towards the start."""
        return int(self.x / voxel_m), int(self.z / voxel_m)


def has_failed(before: np.ndarray, now: np.ndarray, unchanged_m: float) -> bool:
    """Say whether mean and standard deviation of the change of a depth image (H, W), metres, are both below `unchanged_m`."""
    change = np.abs(now - before)
    return bool(change.mean() < unchanged_m and change.std() < unchanged_m)


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """The valid points of one depth image, seen from the believed pose.

    Attributes:
        cells: (N, 2) int, voxels on the floor plane.
        floor: (N,) bool, whether the point is at the height of the floor.
        relevance: (N,) in [0, 1].
        origin: (2,) position of the camera in voxels, not rounded.
        blind: (M, 2) in voxels, not rounded: the nearest point below the camera in every column of space before it.
    """

    cells: np.ndarray
    floor: np.ndarray
    relevance: np.ndarray
    origin: np.ndarray
    blind: np.ndarray


def square(image: np.ndarray, side_px: int) -> np.ndarray:
    """Return an image (H, W, ...) at (side_px, side_px, ...), by nearest neighbour."""
    height, width = image.shape[:2]
    if (height, width) == (side_px, side_px):
        return image
    rows, columns = ((np.arange(side_px) + 0.5) * n / side_px for n in (height, width))
    resized: np.ndarray = image[rows.astype(int)[:, None], columns.astype(int)]
    return resized


def scan(depth: np.ndarray, relevance: np.ndarray, pose: Pose, field_of_view_deg: float, constants: Cow) -> Scan:
    """Return the points of a depth image (S, S), metres along the optical axis, with the relevance (S, S) of its pixels.

    Points nearer than `nearest_depth_m` and above the ceiling are left out.
    """
    aside, up = _lens(len(depth), field_of_view_deg)
    flat = depth.ravel()
    y = up * flat
    ceiling_m = constants.ceiling_m - constants.camera_height_m - constants.floor_tolerance_m
    counts = np.flatnonzero((flat > constants.nearest_depth_m) & (y <= ceiling_m))
    ahead, y = flat[counts], y[counts]
    right = aside[counts] * ahead
    yaw = math.radians(pose.yaw_deg)
    sine, cosine, voxel_m = math.sin(yaw), math.cos(yaw), constants.voxel_m
    x, z = pose.x + cosine * right + sine * ahead, pose.z - sine * right + cosine * ahead
    return Scan(
        cells=np.array([np.rint(x / voxel_m), np.rint(z / voxel_m)], np.int32).T,
        floor=np.abs(y + constants.camera_height_m) <= constants.floor_tolerance_m,
        relevance=relevance.ravel()[counts],
        origin=np.array([pose.x, pose.z]) / voxel_m,
        blind=_nearest(np.rint(right / voxel_m).astype(np.int32), ahead, y < 0.0, x, z) / voxel_m,
    )


def _nearest(column: np.ndarray, ahead: np.ndarray, below: np.ndarray, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return x and z (M, 2) of the nearest point below the camera in every column of voxels before it."""
    points = np.flatnonzero(below)
    if not len(points):
        return np.zeros((0, 2))
    columns = column[points] - column[points].min()
    nearest = np.full(columns.max() + 1, np.inf, ahead.dtype)
    np.minimum.at(nearest, columns, ahead[points])
    first = np.full(len(nearest), -1)
    at = np.flatnonzero(ahead[points] == nearest[columns])
    first[columns[at]] = points[at]
    chosen = first[first >= 0]
    return np.stack([x[chosen], z[chosen]], axis=1)


@lru_cache(maxsize=4)
def _lens(side_px: int, field_of_view_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return metres to the right and up per metre ahead of every pixel's centre, row by row."""
    rows, columns = np.indices((side_px, side_px), dtype=np.float32).reshape(2, -1) + 0.5
    focal_px = side_px / 2 / math.tan(math.radians(field_of_view_deg) / 2)
    return (columns - side_px / 2) / focal_px, (side_px / 2 - rows) / focal_px


Cell = tuple[int, int]

BLOCK = 64
"""The arrays grow by so many voxels at a time, on every side."""
MARGIN = 4
"""Voxels around what is known that the arrays cover."""
EIGHT = ndimage.generate_binary_structure(2, 2)


class VoxelState(IntEnum):
    """State of a voxel of the floor plane. FRONTIER is free, too: it borders on unknown voxels."""

    UNKNOWN = 0
    FREE = 1
    FRONTIER = 2
    OCCUPIED = 3


class VoxelMap:
    """CoW's map: what is known of the floor plane, voxel by voxel, and where the category may be.

    Voxels (i, j) of x and z are counted from the start of the episode and negative behind it. Heights are collapsed onto the
    layer of the floor: everything above it, below the ceiling, is an obstacle.

    Attributes:
        regions: The voxels that may be the category (regions of interest), in the order of their distance to the agent when the
            last of them was found.
    """

    def __init__(self, constants: Cow) -> None:
        self._constants = constants
        self._origin = np.full(2, -BLOCK // 2)
        self._state = np.zeros((BLOCK, BLOCK), np.uint8)
        self._relevance = np.zeros((BLOCK, BLOCK), np.float32)
        self._interest = np.zeros((BLOCK, BLOCK), bool)
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
        """Return the state of a cell."""
        i, j = cell[0] - self._origin[0], cell[1] - self._origin[1]
        inside = 0 <= i < self._state.shape[0] and 0 <= j < self._state.shape[1]
        return VoxelState(int(self._state[i, j])) if inside else VoxelState.UNKNOWN

    def states(self, cells: np.ndarray) -> np.ndarray:
        """Return the states (N,) uint8 of cells (N, 2)."""
        inner = cells - self._origin
        inside = ((inner >= 0) & (inner < self._state.shape)).all(axis=1)
        found = np.zeros(len(cells), np.uint8)
        found[inside] = self._state[inner[inside, 0], inner[inside, 1]]
        return found

    def visit(self, cell: Cell) -> None:
        """Mark a frontier and its neighbourhood as visited: they stop being targets."""
        reach = self._constants.visited_voxels // 2
        i, j = cell[0] - self._origin[0], cell[1] - self._origin[1]
        self._visited[max(i - reach, 0) : i + reach + 1, max(j - reach, 0) : j + reach + 1] = True

    def is_visited(self, cell: Cell) -> bool:
        """Say whether a frontier was marked as visited."""
        return bool(self._visited[cell[0] - self._origin[0], cell[1] - self._origin[1]])

    def update(self, seen: Scan, agent: Cell) -> None:
        """Take a scan into the map. Later rules overwrite earlier ones, in the published order."""
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
        # The body is wider than a voxel: it cannot stand in the four neighbours of an obstacle.
        state[_with_neighbours(occupied, outside=False)] = VoxelState.OCCUPIED
        next_to_unknown = _with_neighbours(state == VoxelState.UNKNOWN, outside=True)
        state[(state == VoxelState.FREE) & next_to_unknown] = VoxelState.FRONTIER
        self._take_interest(seen, element, occupied, agent)

    def _pad(self, seen: Scan) -> None:
        """Free the unknown voxels on the rays to the nearest points below the camera: the floor that it does not see."""
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
        """Update relevances and regions of interest. element: (N,) index of each point in the flattened arrays."""
        counts = np.flatnonzero((seen.relevance > 0) & ~seen.floor)
        if len(counts):
            order = counts[np.argsort(seen.relevance[counts], kind="stable")]
            order = order[seen.relevance[order] > self._relevance.ravel()[element[order]]]
            self._relevance.ravel()[element[order]] = seen.relevance[order]
            self._interest.ravel()[element[counts[seen.relevance[counts] > self._constants.relevant]]] = True
        here = np.argwhere(occupied & self._interest) + self._origin
        if len(here):
            nearest = here[np.argmin(np.hypot(*(here - np.array(agent)).T))]
            region = (int(nearest[0]), int(nearest[1]))
            if region not in self.regions:
                self.regions = tuple(
                    sorted({*self.regions, region}, key=lambda c: (np.hypot(c[0] - agent[0], c[1] - agent[1]), c))
                )

    def _cover(self, seen: Scan, agent: Cell) -> None:
        """Grow the arrays to the scan, with a margin for the neighbours."""
        points = np.concatenate([[agent], [np.rint(seen.origin).astype(int)], seen.cells])
        outside = max(
            (self._origin - points.min(axis=0)).max(), (points.max(axis=0) + 1 - self._origin - self._state.shape).max()
        )
        if outside + MARGIN > 0:
            grown = -(-int(outside + MARGIN) // BLOCK) * BLOCK
            self._origin = self._origin - grown
            for name in ("_state", "_relevance", "_interest", "_visited"):
                setattr(self, name, np.pad(getattr(self, name), grown))


def _with_neighbours(chosen: np.ndarray, outside: bool) -> np.ndarray:
    """Return the chosen cells (A, B) and the four neighbours of each.

    outside: whether cells outside the array count as chosen.
    """
    padded = np.pad(chosen, 1, constant_values=outside)
    grown: np.ndarray = chosen | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]
    return grown
