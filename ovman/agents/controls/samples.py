"""The frames of a tour at every n-th pixel, and what one tour shows from the cameras of another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Visit
from ovman.perception.backprojection import Camera, pixel_points

NEAREST_M = 0.05
"""What is nearer to a camera than this, or behind it, is not in its picture."""
AROUND = 3
"""Cells on each side of the square in which a carried picture is compared: points fall between the cells."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """A frame at every n-th pixel, h rows of w. rgb (h, w, 3) in [0, 1]; depth (h, w) in metres along the optical axis, NaN where
    it is not known; points (h, w, 3): where that is in the world; pose, camera: of the frame; shape: (H, W) of the frame."""

    rgb: np.ndarray
    depth: np.ndarray
    points: np.ndarray
    pose: CameraPose
    camera: Camera
    shape: tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What a tour shows from a camera: depth (h, w) in metres, and the bounds (h, w, 3) of the colour. NaN where it shows nothing."""

    depth: np.ndarray
    darkest: np.ndarray
    lightest: np.ndarray


def sampled(visit: Visit, every_px: int) -> tuple[Sample, ...]:
    """The frames of a visit at every `every_px`-th row and column. ValueError for a tour without pictures."""
    return tuple(_sample(frame, every_px) for frame in visit.observations)


def _sample(frame: Observation, every_px: int) -> Sample:
    if frame.rgb is None or frame.depth is None:
        raise ValueError("a control compares pictures; write needs: [tours] in its entry")
    pose = frame.pose
    camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, frame.field_of_view_deg)
    height, width = frame.depth.shape
    rows, columns = np.meshgrid(*(np.arange(every_px // 2, side, every_px) for side in (height, width)), indexing="ij")
    depth = frame.depth[rows, columns].astype(np.float64)
    points = pixel_points(frame.depth, rows.ravel(), columns.ravel(), camera).reshape(*rows.shape, 3)
    rgb = frame.rgb[rows, columns] / 255.0
    return Sample(rgb, np.where(depth > 0, depth, np.nan), points, pose, camera, (height, width))


def shown_from(sample: Sample, tour: Sequence[Sample], every_px: int) -> Shown:
    """What `tour` shows from the camera of `sample`: its own frame from that very pose if it has one, else all frames carried there.

    A carried picture has the nearest depth and the bounds of the colours of the cells around each cell.
    """
    for other in tour:
        if other.pose == sample.pose and other.camera == sample.camera and other.depth.shape == sample.depth.shape:
            return Shown(other.depth, other.rgb, other.rgb)
    return _carried(sample, tour, every_px)


def _carried(sample: Sample, tour: Sequence[Sample], every_px: int) -> Shown:
    from scipy.ndimage import maximum_filter, minimum_filter  # takes a quarter of a second, and equal tours need none of it

    depth = np.full(sample.depth.shape, np.inf)
    darkest, lightest = np.full(sample.rgb.shape, np.inf), np.full(sample.rgb.shape, -np.inf)
    if tour:
        known = [np.isfinite(other.depth) for other in tour]
        points = np.concatenate([other.points[there] for other, there in zip(tour, known, strict=True)])
        colours = np.concatenate([other.rgb[there] for other, there in zip(tour, known, strict=True)])
        cells, away, chosen = _cells(points, sample, every_px)
        # Of the points of a cell the nearest is seen: it is written last.
        order = np.argsort(-away, kind="stable")
        cell = tuple(cells[:, order])
        depth[cell] = away[order]
        darkest[cell] = lightest[cell] = colours[chosen[order]]
    depth = minimum_filter(depth, AROUND, mode="nearest")
    darkest = minimum_filter(darkest, (AROUND, AROUND, 1), mode="nearest")
    lightest = maximum_filter(lightest, (AROUND, AROUND, 1), mode="nearest")
    return Shown(*(np.where(np.isfinite(part), part, np.nan) for part in (depth, darkest, lightest)))


def _cells(points: np.ndarray, sample: Sample, every_px: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells (2, N) of the sample's picture that the points in it fall into, their depths (N,), and which points these are (N,)."""
    height, width = sample.shape
    aside, up, away = ((points - np.array(sample.camera.position)) @ sample.camera.axes()).T
    ahead = np.flatnonzero(away > NEAREST_M)
    focal_px = height / 2 / math.tan(math.radians(sample.camera.field_of_view_deg) / 2)
    rows = np.floor((height / 2 - focal_px * up[ahead] / away[ahead]) / every_px).astype(np.int64)
    columns = np.floor((width / 2 + focal_px * aside[ahead] / away[ahead]) / every_px).astype(np.int64)
    inside = (rows >= 0) & (rows < sample.depth.shape[0]) & (columns >= 0) & (columns < sample.depth.shape[1])
    chosen = ahead[inside]
    return np.stack([rows[inside], columns[inside]]), away[chosen], chosen
