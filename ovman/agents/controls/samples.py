"""The frames of a tour at every n-th pixel, and what the frames of another tour show at the same places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Visit
from ovman.perception.backprojection import Camera, pixel_points

NEAREST_M = 0.05
"""What is nearer to a camera than this, or behind it, is not in its picture."""
NO_PICTURES = "a control compares pictures; write needs: [tours] in its entry"
AROUND = 3
"""Cells on each side of the square that stands for a place in a picture: places fall between the cells."""


@dataclass(frozen=True, eq=False)
class Sample:
    """A frame at every n-th pixel, h rows of w. depth (h, w) in metres along the optical axis, NaN where it is not known; points
    (h, w, 3): where that is in the world; camera: of the frame; frame, pixels: which it is of, and its rows and columns."""

    depth: np.ndarray
    points: np.ndarray
    camera: Camera
    frame: Observation
    pixels: tuple[np.ndarray, np.ndarray]

    @property
    def pose(self) -> CameraPose:
        """Of the frame."""
        return self.frame.pose

    @cached_property
    def shape(self) -> tuple[int, int]:
        """(H, W) of the frame."""
        assert self.frame.depth is not None
        height, width = self.frame.depth.shape
        return height, width

    @cached_property
    def rgb(self) -> np.ndarray:
        """(h, w, 3) in [0, 1]. ValueError for a frame without colours. Read where it is asked for: depth alone needs none."""
        if self.frame.rgb is None:
            raise ValueError(NO_PICTURES)
        colours: np.ndarray = self.frame.rgb[self.pixels] / 255.0
        return colours

    @cached_property
    def nearest(self) -> np.ndarray:
        """The least depth (h, w) in the square around each cell, inf where none is known."""
        from scipy.ndimage import minimum_filter  # takes a quarter of a second, and equal tours need none of it

        least: np.ndarray = minimum_filter(np.where(np.isfinite(self.depth), self.depth, np.inf), AROUND, mode="nearest")
        return least

    @cached_property
    def colours(self) -> tuple[np.ndarray, np.ndarray]:
        """The darkest and the lightest of each channel (h, w, 3) in the square around each cell."""
        from scipy.ndimage import maximum_filter, minimum_filter

        square = AROUND, AROUND, 1
        return minimum_filter(self.rgb, square, mode="nearest"), maximum_filter(self.rgb, square, mode="nearest")


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What a frame of another tour shows at the places (h, w) of a sample that are in its picture.

    which: of the places, an index into h w of them, which selects k. away (k,): a place's depth for that frame's camera; depth
    (k,): the nearest depth that the frame shows there, NaN where none is known; both in metres. own, colours: give the colours of
    the sample at the places (k, 3), and the bounds of each channel that the frame shows there, the darkest and the lightest, both
    (k, 3), NaN where the place is hidden.
    """

    which: np.ndarray | slice
    away: np.ndarray
    depth: np.ndarray
    own: Callable[[], np.ndarray]
    colours: Callable[[], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class _Sampled:
    """A recorded tour by what it shows, and how it is sampled."""

    content: str
    every_px: int
    visit: Visit = field(compare=False, repr=False)


def sampled(visit: Visit, every_px: int) -> tuple[Sample, ...]:
    """The frames of a visit at every `every_px`-th row and column. ValueError for a tour without pictures.

    A recorded tour is sampled once for the episodes in a row that have it as their first or second.
    """
    if visit.content is None:
        return _sample_all(visit, every_px)
    return _sample_once(_Sampled(visit.content, every_px, visit))


def _sample_all(visit: Visit, every_px: int) -> tuple[Sample, ...]:
    return tuple(_sample(frame, every_px) for frame in visit.observations)


@lru_cache(maxsize=2)
def _sample_once(asked: _Sampled) -> tuple[Sample, ...]:
    return _sample_all(asked.visit, asked.every_px)


def _sample(frame: Observation, every_px: int) -> Sample:
    if frame.depth is None:
        raise ValueError(NO_PICTURES)
    pose = frame.pose
    camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, frame.field_of_view_deg)
    height, width = frame.depth.shape
    rows, columns = np.meshgrid(*(np.arange(every_px // 2, side, every_px) for side in (height, width)), indexing="ij")
    depth = frame.depth[rows, columns].astype(np.float64)
    points = pixel_points(frame.depth, rows.ravel(), columns.ravel(), camera).reshape(*rows.shape, 3)
    return Sample(np.where(depth > 0, depth, np.nan), points, camera, frame, (rows, columns))


def shown_at(sample: Sample, tour: Sequence[Sample], every_px: int, hidden_m: float) -> Iterator[Shown]:
    """What the frames of `tour` show at the places of `sample`: that of the very pose alone if there is one, else all that have
    any of them in their pictures.

    A place is hidden where a frame shows something nearer by more than `hidden_m`. In the frame of the very pose nothing is
    hidden: pixel stands against pixel.
    """
    for other in tour:
        if other.pose == sample.pose and other.camera == sample.camera and other.depth.shape == sample.depth.shape:
            yield Shown(slice(None), sample.depth.ravel(), other.depth.ravel(), partial(_colours, sample), partial(_twice, other))
            return
    for other in tour:
        shown = _shown(sample, other, every_px, hidden_m)
        if len(shown.away):
            yield shown


def _colours(sample: Sample) -> np.ndarray:
    return sample.rgb.reshape(-1, 3)


def _twice(sample: Sample) -> tuple[np.ndarray, np.ndarray]:
    return _colours(sample), _colours(sample)


def _shown(sample: Sample, other: Sample, every_px: int, hidden_m: float) -> Shown:
    rows, columns, away, inside = _cells(sample.points.reshape(-1, 3), other, every_px)
    depth = other.nearest[rows, columns]
    depth[~np.isfinite(depth)] = np.nan

    def own() -> np.ndarray:
        colours: np.ndarray = _colours(sample)[inside]
        return colours

    def colours() -> tuple[np.ndarray, np.ndarray]:
        seen = depth > away - hidden_m
        darkest, lightest = np.full((2, len(inside), 3), np.nan)
        darkest[seen], lightest[seen] = (extreme[rows[seen], columns[seen]] for extreme in other.colours)
        return darkest, lightest

    return Shown(inside, away, depth, own, colours)


def _cells(points: np.ndarray, other: Sample, every_px: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns (N,) of a sample's cells that points fall into, their depths (N,), and which points these are (N,)."""
    height, width = other.shape
    aside, up, away = ((points - np.array(other.camera.position)) @ other.camera.axes()).T
    ahead = np.flatnonzero(away > NEAREST_M)
    focal_px = height / 2 / math.tan(math.radians(other.camera.field_of_view_deg) / 2)
    rows = np.floor((height / 2 - focal_px * up[ahead] / away[ahead]) / every_px).astype(np.int64)
    columns = np.floor((width / 2 + focal_px * aside[ahead] / away[ahead]) / every_px).astype(np.int64)
    inside = (rows >= 0) & (rows < other.depth.shape[0]) & (columns >= 0) & (columns < other.depth.shape[1])
    chosen = ahead[inside]
    return rows[inside], columns[inside], away[chosen], chosen
