"""Compute positions in the world from the depth of a mask's pixels (Eq. backproj).

World frame: Unity's, left-handed, y up, metres; yaw 0 looks along +z and 90 along +x, a positive horizon looks down. Images have
row 0 at the top and square pixels, whose centres lie at +0.5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SLACK_M = 1e-6
"""More than the rounding errors of a projection."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Pose and lens of a frame: position (x, y, z) in metres, yaw and horizon in degrees, vertical field of view in degrees."""

    position: tuple[float, float, float]
    yaw_deg: float
    horizon_deg: float
    field_of_view_deg: float

    @lru_cache(maxsize=256)  # noqa: B019 (few, small, and asked for again for every pair of frames)
    def axes(self) -> np.ndarray:
        """Return the columns right, up and forward (3, 3): R of Eq. backproj, for a camera that looks along its +z with +y up."""
        sin_yaw, cos_yaw = math.sin(math.radians(self.yaw_deg)), math.cos(math.radians(self.yaw_deg))
        sin_tilt, cos_tilt = math.sin(math.radians(self.horizon_deg)), math.cos(math.radians(self.horizon_deg))
        axes = np.array(
            [
                [cos_yaw, sin_yaw * sin_tilt, sin_yaw * cos_tilt],
                [0.0, cos_tilt, -sin_tilt],
                [-sin_yaw, cos_yaw * sin_tilt, cos_yaw * cos_tilt],
            ]
        )
        axes.flags.writeable = False
        return axes


def world_points(depth: np.ndarray, mask: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the world points (N, 3) of the N pixels of `mask` (H, W) bool, metres. `depth` (H, W): along the optical axis."""
    rows, columns = np.nonzero(mask)
    return pixel_points(depth, rows, columns, camera)


def pixel_points(depth: np.ndarray, rows: np.ndarray, columns: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the world points (N, 3) of N pixels, metres. `depth` (H, W): along the optical axis."""
    rays = _rays(rows + 0.5, columns + 0.5, depth.shape, camera)
    points: np.ndarray = rays * depth[rows, columns, None] + np.array(camera.position)
    return points


def project(points: np.ndarray, camera: Camera, shape: tuple[int, int], nearest_m: float) -> tuple[np.ndarray, ...]:
    """Return which points (M,) of N (N, 3) lie farther ahead than `nearest_m`, and their rows, columns and depths (M,).

    Rows and columns are those of a frame of that shape (H, W), not rounded; they may lie outside.
    """
    height, width = shape
    aside, up, away = ((points - np.array(camera.position)) @ camera.axes()).T
    focal_px = height / 2 / math.tan(math.radians(camera.field_of_view_deg) / 2)
    ahead = np.flatnonzero(away > nearest_m)
    depth = away[ahead]
    return ahead, height / 2 - focal_px * up[ahead] / depth, width / 2 + focal_px * aside[ahead] / depth, depth


def may_show(points: np.ndarray, frames: Sequence[tuple[Camera, tuple[int, int]]]) -> np.ndarray:
    """Return for each of M frames, a camera and a shape (H, W), whether it may show one of N >= 1 points (N, 3): (M,) bool.

    False only if the box of the points lies beyond one side of the picture: `project` of such frames finds nothing.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    relative = corners - np.array([camera.position for camera, _ in frames]).reshape(-1, 1, 3)
    axes = np.array([camera.axes() for camera, _ in frames]).reshape(-1, 3, 3)
    aside, up, away = np.moveaxis(relative @ axes, 2, 0)
    slopes = np.array([math.tan(math.radians(camera.field_of_view_deg) / 2) for camera, _ in frames])[:, None]
    high_m = away * slopes + SLACK_M
    wide_m = away * (slopes * np.array([width / height for _, (height, width) in frames])[:, None]) + SLACK_M
    beyond = np.stack([up > high_m, -up > high_m, aside > wide_m, -aside > wide_m, away < 0])
    return np.asarray(~beyond.all(axis=2).any(axis=0))


def median_point(depth: np.ndarray, mask: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the component-wise median (3,) of a mask's world points (Eq. backproj). Raises ValueError for an empty mask."""
    if not mask.any():
        raise ValueError("an empty mask has no position")
    point: np.ndarray = np.median(world_points(depth, mask, camera), axis=0)
    return point


def median_points(depth: np.ndarray, masks: np.ndarray, camera: Camera) -> np.ndarray:
    """Return `median_point` (N, 3) of N masks (N, H, W) bool of one frame, over their pixels that have depth (more than 0).

    NaN for a mask without depth.
    """
    height, width = depth.shape
    lens, axes, flat = _lens(height, width, camera.field_of_view_deg), camera.axes(), depth.ravel()
    there = flat > 0
    medians = np.full((len(masks), 3), np.nan)
    for found, mask in zip(medians, masks.reshape(len(masks), height * width), strict=True):
        inside = np.flatnonzero(mask & there)
        if len(inside):
            found[:] = np.median(axes @ (lens[:, inside] * flat[inside]), axis=1) + camera.position
    return medians


def extents(depth: np.ndarray, masks: np.ndarray, camera: Camera, share: float) -> np.ndarray:
    """Return the axis-aligned extents (N, 3), metres, of the world points of N masks (N, H, W) bool of one frame.

    They are the longer and the shorter side on the floor plane, and the height. A side spans the middle `share` of the points
    along its axis, over the pixels that have depth, so that a few pixels of the background do not count. NaN without depth.
    """
    height, width = depth.shape
    lens, axes, flat = _lens(height, width, camera.field_of_view_deg), camera.axes(), depth.ravel()
    there = flat > 0
    sides = np.full((len(masks), 3), np.nan)
    for found, mask in zip(sides, masks.reshape(len(masks), height * width), strict=True):
        inside = np.flatnonzero(mask & there)
        if len(inside):
            ends = [round((len(inside) - 1) * (1 + sign * share) / 2) for sign in (-1, 1)]
            low, high = np.partition(axes @ (lens[:, inside] * flat[inside]), ends, axis=1)[:, ends].T
            x, y, z = high - low
            found[:] = max(x, z), min(x, z), y
    return sides


def single_ray_point(depth: np.ndarray, mask: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the point (3,) on the ray through the middle of a mask at its median depth. Raises ValueError for an empty mask.

    The self-check of the paper warns of this estimate: for a mask that is not convex, or whose depth jumps, the point lies on no
    surface.
    """
    rows, columns = np.nonzero(mask)
    if not len(rows):
        raise ValueError("an empty mask has no position")
    ray = _rays(np.array([rows.mean() + 0.5]), np.array([columns.mean() + 0.5]), depth.shape, camera)[0]
    point: np.ndarray = ray * np.median(depth[rows, columns]) + np.array(camera.position)
    return point


@lru_cache(maxsize=4)
def _lens(height: int, width: int, field_of_view_deg: float) -> np.ndarray:
    """Return K^-1 (u, v, 1) of every pixel of a frame, row by row: (3, height * width)."""
    rows, columns = np.indices((height, width)).reshape(2, -1) + 0.5
    return _camera_rays(rows, columns, height, width, field_of_view_deg)


def _rays(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, ...], camera: Camera) -> np.ndarray:
    """Return R K^-1 (u, v, 1) of image points: (N, 3), one metre along the optical axis."""
    rays: np.ndarray = (camera.axes() @ _camera_rays(rows, columns, shape[0], shape[1], camera.field_of_view_deg)).T
    return rays


def _camera_rays(rows: np.ndarray, columns: np.ndarray, height: int, width: int, field_of_view_deg: float) -> np.ndarray:
    """Return K^-1 (u, v, 1) of image points, for a camera that looks along +z with +y up: (3, N)."""
    focal_px = height / 2 / math.tan(math.radians(field_of_view_deg) / 2)
    aside, up = (columns - width / 2) / focal_px, (height / 2 - rows) / focal_px
    return np.stack([aside, up, np.ones_like(aside)])
