"""DynaMem's memory of features: voxels that hold what was seen there last, and nothing that a later view saw through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.dynamem import Dynamem
from ovman.agents.interface import Visit
from ovman.agents.sharing import keep_last
from ovman.perception.backprojection import Camera, pixel_points, project
from ovman.perception.records import Detected

_BITS = 20
"""Bits of a voxel's number along an axis."""
_APART_M = 1000.0
"""Added to the place of a point for each frame: only points of one frame are neighbours."""

# Frames -----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A frame with its D detections, and N points of them. A pixel of two detections is two points.

    Attributes:
        depth: (H, W) metres along the optical axis.
        camera: The camera.
        masked: (H, W) bool, the pixels of a detection.
        points: (N, 3) world points, metres.
        of: (N,) the detection of each point.
        features: (D, K) unit embeddings.
        places: (D, 3) medians of the masks' world points, metres.
        nearest_m: (D,) least depth of each mask.
    """

    depth: np.ndarray
    camera: Camera
    masked: np.ndarray
    points: np.ndarray
    of: np.ndarray
    features: np.ndarray
    places: np.ndarray
    nearest_m: np.ndarray


@keep_last
def look_at_tour(visit: Visit, detected: Detected, constants: Dynamem) -> tuple[Look, ...]:
    """Return the frames of a visit with their detections. Raises ValueError for a tour without pictures."""
    if not len(visit.observations):
        return ()
    every = detected.masks()
    found = []
    for number, frame in enumerate(visit.observations):
        if frame.depth is None:
            raise ValueError("DynaMem reads depth; write needs: [tours, detections] in its entry")
        mine = detected.view == number
        found.append(look(frame.depth, frame.camera, every[mine], detected.feature[mine], detected.point[mine], constants))
    return tuple(found)


def look(
    depth: np.ndarray, camera: Camera, masks: np.ndarray, features: np.ndarray, places: np.ndarray, constants: Dynamem
) -> Look:
    """Return a frame of depth (H, W) with the masks (D, H, W) bool, features (D, K) and places (D, 3) of its detections.

    Of a mask the pixels at every n-th row and column become points if their depth is within the range and close to the median
    of the pixels around them.
    """
    rows, columns = (np.arange(constants.every_px // 2, side, constants.every_px) for side in depth.shape)
    steady = np.zeros((len(rows), len(columns)), bool)
    seen = masks[:, rows[:, None], columns[None, :]]
    asked = seen.any(axis=0)
    at = rows[np.nonzero(asked)[0]], columns[np.nonzero(asked)[1]]
    steady[asked] = _is_steady(depth, *at, constants)
    of, row, column = np.nonzero(seen & steady)
    known = np.where(depth > constants.unknown_m, depth, np.inf)
    return Look(
        depth=depth,
        camera=camera,
        masked=np.logical_or.reduce(masks, axis=0),
        points=pixel_points(depth, rows[row], columns[column], camera),
        of=of,
        features=np.asarray(features, np.float64),
        places=places,
        nearest_m=np.array([known[mask].min(initial=np.inf) for mask in masks]),
    )


def _is_steady(depth: np.ndarray, rows: np.ndarray, columns: np.ndarray, constants: Dynamem) -> np.ndarray:
    """Return which of N pixels (N,) have a depth within the range, close to the median of the square around them."""
    half = constants.median_px // 2
    around = np.lib.stride_tricks.sliding_window_view(np.pad(depth, half, mode="symmetric"), (constants.median_px,) * 2)
    own = depth[rows, columns]
    median = np.median(around[rows, columns].reshape(len(rows), constants.median_px**2), axis=1)
    within = (own > constants.nearest_m) & (own < constants.farthest_m)
    steady: np.ndarray = within & (np.abs(own - median) < constants.median_error_m)
    return steady


# Memory -----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """V voxels in the order of `cell`.

    Attributes:
        cell: (V,) number of the voxel.
        point: (V, 3) mean of its points, metres.
        weight: (V,) number of its points.
        seen: (V,) number of the frame that added to it last.
        feature: (V, K) mean of the features of its points.
    """

    cell: np.ndarray
    point: np.ndarray
    weight: np.ndarray
    seen: np.ndarray
    feature: np.ndarray

    @staticmethod
    def empty() -> Memory:
        """Return a memory of nothing."""
        none = np.zeros(0, np.int64)
        return Memory(none, np.zeros((0, 3)), np.zeros(0), none, np.zeros((0, 0)))

    def __len__(self) -> int:
        return len(self.cell)

    def select(self, kept: np.ndarray) -> Memory:
        """Return the voxels of a mask (V,) bool."""
        return self if kept.all() else Memory(*(getattr(self, name)[kept] for name in Memory.__slots__))


def remember_tours(tours: Sequence[tuple[Visit, Detected]], constants: Dynamem) -> tuple[Memory, tuple[Look, ...]]:
    """Return one memory of the frames of all tours, and the frames."""
    frames = tuple(frame for visit, detected in tours for frame in look_at_tour(visit, detected, constants))
    return remember(frames, constants), frames


@keep_last
def remember(frames: tuple[Look, ...], constants: Dynamem) -> Memory:
    """Return the memory after frames in their order."""
    memory, checked = Memory.empty(), np.zeros(len(frames), np.int64)
    for number, look in enumerate(frames):
        memory = clear(memory, look, constants)
        # Voxels of different frames are not neighbours, so only frames that have lost or gained some can have new noise.
        counts = np.bincount(memory.seen, minlength=len(frames))
        memory = remove_noise(memory, np.flatnonzero(counts != checked), constants)
        checked = np.bincount(memory.seen, minlength=len(frames))
        memory = add(memory, look, number, constants.voxel_m)
    return memory


def clear(memory: Memory, look: Look, constants: Dynamem) -> Memory:
    """Return the memory without the voxels that a frame sees through or that a detection shows again.

    Of the points in the picture up to `farthest_m` away, those go whose pixel shows something farther, and those that a detection
    shows again, which gives them its feature. What is hidden stays, and so does a surface that is seen again without a
    detection, as far off as before by at most a voxel's side.
    """
    if not len(memory):
        return memory
    height, width = look.depth.shape
    voxels, rows, columns, away = project(memory.point, look.camera, (height, width), 0.0)
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    voxels, row, column, away = voxels[inside], rows[inside].astype(np.int64), columns[inside].astype(np.int64), away[inside]
    depth = look.depth[row, column]
    judged = (away >= constants.unknown_m) & (away <= constants.farthest_m) & (depth >= constants.unknown_m)
    judged &= depth >= away - constants.hidden_m
    kept = np.ones(len(memory), bool)
    kept[voxels[judged & (look.masked[row, column] | (depth > away + constants.voxel_m))]] = False
    return memory.select(kept)


def remove_noise(memory: Memory, frames: Sequence[int] | np.ndarray, constants: Dynamem) -> Memory:
    """Return the memory without DBSCAN's noise in these frames: voxels that are not among enough others of their frame."""
    from scipy.spatial import cKDTree  # imported only if a memory is made: the import takes a quarter of a second

    asked = np.flatnonzero(np.isin(memory.seen, frames))
    if not len(asked):
        return memory
    within = np.nextafter(constants.cluster_voxels * constants.voxel_m, np.inf)
    places = np.column_stack([memory.point[asked], memory.seen[asked] * _APART_M])
    core = np.isfinite(cKDTree(places).query(places, [constants.cluster_points], distance_upper_bound=within)[0][:, 0])
    kept = np.ones(len(memory), bool)
    kept[asked] = core
    if core.any() and not core.all():
        distance, _ = cKDTree(places[core]).query(places[~core], distance_upper_bound=within)
        kept[asked[~core]] = np.isfinite(distance)
    return memory.select(kept)


def add(memory: Memory, look: Look, number: int, voxel_m: float) -> Memory:
    """Return the memory with the points of the frame of that number."""
    if not len(look.points):
        return memory
    cells, which = np.unique(_cells(look.points, voxel_m), return_inverse=True)
    points = np.column_stack([np.bincount(which, along) for along in look.points.T])
    shares = np.bincount(which * len(look.features) + look.of, minlength=len(cells) * len(look.features))
    weight: np.ndarray = np.bincount(which).astype(np.float64)
    features: np.ndarray = shares.reshape(len(cells), len(look.features)) @ look.features
    again = np.isin(memory.cell, cells, assume_unique=True)
    if again.any():
        into = np.searchsorted(cells, memory.cell[again])
        points[into] += memory.point[again] * memory.weight[again, None]
        features[into] += memory.feature[again] * memory.weight[again, None]
        weight[into] += memory.weight[again]
    seen = np.full(len(cells), number, np.int64)
    new = Memory(cells, points / weight[:, None], weight, seen, features / weight[:, None])
    if again.all():
        return new
    left = memory.select(~again)
    order = np.argsort(np.concatenate([left.cell, cells]))
    return Memory(*(np.concatenate([getattr(one, name) for one in (left, new)])[order] for name in Memory.__slots__))


def _cells(points: np.ndarray, voxel_m: float) -> np.ndarray:
    """Return the numbers (N,) of the voxels of points (N, 3), in the order of x, y, z."""
    x, y, z = (np.floor(points / voxel_m).astype(np.int64) + (1 << (_BITS - 1))).T
    numbers: np.ndarray = (x << (2 * _BITS)) | (y << _BITS) | z
    return numbers
