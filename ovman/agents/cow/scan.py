"""From a depth image to points in the frame of the episode's start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ovman.agents.cow.odometry import Pose
from ovman.agents.cow.settings import Cow


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """The valid points of one depth image, seen from the believed pose.

    cells: (N, 2) int, voxels on the floor plane; floor: (N,) bool, whether at the height of the floor; height: (N,) metres above
    the camera; relevance: (N,) in [0, 1]; origin: (2,) position of the camera in voxels, not rounded; blind: (M, 2) in voxels,
    not rounded, the nearest point below the camera in every column of space before it.
    """

    cells: np.ndarray
    floor: np.ndarray
    height: np.ndarray
    relevance: np.ndarray
    origin: np.ndarray
    blind: np.ndarray


def square(image: np.ndarray, side_px: int) -> np.ndarray:
    """An image (H, W, ...) at (side_px, side_px, ...), by nearest neighbour."""
    height, width = image.shape[:2]
    if (height, width) == (side_px, side_px):
        return image
    rows, columns = ((np.arange(side_px) + 0.5) * n / side_px for n in (height, width))
    resized: np.ndarray = image[rows.astype(int)[:, None], columns.astype(int)]
    return resized


def scan(depth: np.ndarray, relevance: np.ndarray, pose: Pose, field_of_view_deg: float, constants: Cow) -> Scan:
    """The points of a depth image (S, S), metres along the optical axis, with the relevance (S, S) of its pixels.

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
        height=y,
        relevance=relevance.ravel()[counts],
        origin=np.array([pose.x, pose.z]) / voxel_m,
        blind=_nearest(np.rint(right / voxel_m).astype(np.int32), ahead, y < 0.0, x, z) / voxel_m,
    )


def _nearest(column: np.ndarray, ahead: np.ndarray, below: np.ndarray, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """(M, 2): x and z of the nearest point below the camera in every column of voxels before it."""
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
    """Metres to the right and up for each metre ahead, of every pixel's centre, row by row."""
    rows, columns = np.indices((side_px, side_px), dtype=np.float32).reshape(2, -1) + 0.5
    focal_px = side_px / 2 / math.tan(math.radians(field_of_view_deg) / 2)
    return (columns - side_px / 2) / focal_px, (side_px / 2 - rows) / focal_px
