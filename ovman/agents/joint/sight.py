"""What the frames of a tour show at places: something there, or through to what lies behind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Observation, Visit
from ovman.models.settings.joint import Joint
from ovman.perception.backprojection import Camera, pixel_points

NEAREST_M = 0.2
"""What is nearer to a camera than this, or behind it, is not in its picture."""
AROUND = tuple((row, column) for row in (-1, 0, 1) for column in (-1, 0, 1))


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame and its grid of every n-th pixel, h rows of w.

    depth (H, W): metres along the optical axis, 0 where it is not known; rows (h,), columns (w,): of the grid's pixels;
    points (h, w, 3): where they lie in the world, metres; known (h, w) bool: whether they have depth.
    """

    depth: np.ndarray
    camera: Camera
    rows: np.ndarray
    columns: np.ndarray
    points: np.ndarray
    known: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Votes:
    """How many frames see through each of N places, and how many see something at it; places hidden from a frame get no vote."""

    through: np.ndarray
    at: np.ndarray

    def of(self, places: np.ndarray) -> Votes:
        """The votes of some of the places, by their indices or a mask."""
        return Votes(self.through[places], self.at[places])

    @property
    def open(self) -> np.ndarray:
        """(N,) bool: places that more frames see through than see something at."""
        found: np.ndarray = self.through > self.at
        return found

    @property
    def observed(self) -> np.ndarray:
        """(N,) bool: places that some frame says something of."""
        found: np.ndarray = (self.through + self.at) > 0
        return found


def frames(visit: Visit, constants: Joint) -> tuple[Frame, ...]:
    """The frames of a visit. ValueError for a tour without pictures."""
    return tuple(frame(one, constants) for one in visit.observations)


def frame(observation: Observation, constants: Joint) -> Frame:
    """The frame of one observation. ValueError for one without depth."""
    if observation.depth is None:
        raise ValueError("the joint agent reads depth; write needs: [tours, detections] in its entry")
    depth, pose = np.asarray(observation.depth, np.float64), observation.pose
    camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, observation.field_of_view_deg)
    rows, columns = (np.arange(constants.every_px // 2, side, constants.every_px) for side in depth.shape)
    at = np.meshgrid(rows, columns, indexing="ij")
    points = pixel_points(depth, at[0].ravel(), at[1].ravel(), camera).reshape(*at[0].shape, 3)
    return Frame(depth, camera, rows, columns, points, depth[at[0], at[1]] > 0)


def votes(points: np.ndarray, seen_by: Iterable[Frame], constants: Joint) -> Votes:
    """The votes of frames on places (N, 3), metres.

    A frame sees through a place where everything around its pixel is farther by more than the tolerance, and something at it where
    some of that is within the tolerance. Depth and poses err the more, the farther away a place is, and so grows the tolerance.
    """
    through, at = np.zeros(len(points), np.int64), np.zeros(len(points), np.int64)
    for one in seen_by:
        places, beyond, away = _beyond(points, one)
        tolerance = constants.tolerance_m + constants.tolerance_per_m * away
        through[places[beyond > tolerance]] += 1
        at[places[np.abs(beyond) <= tolerance]] += 1
    return Votes(through, at)


def _beyond(points: np.ndarray, seen_by: Frame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which places (M,) are in a frame's picture, by how many metres what it shows there is farther than they are, and how far
    away they are, metres. Of the depths around the place's pixel the one nearest to the place's counts, 0 if it lies among them."""
    height, width = seen_by.depth.shape
    aside, up, away = ((points - np.array(seen_by.camera.position)) @ seen_by.camera.axes()).T
    ahead = np.flatnonzero(away > NEAREST_M)
    focal_px = height / 2 / math.tan(math.radians(seen_by.camera.field_of_view_deg) / 2)
    rows = np.floor(height / 2 - focal_px * up[ahead] / away[ahead]).astype(np.int64)
    columns = np.floor(width / 2 + focal_px * aside[ahead] / away[ahead]).astype(np.int64)
    inside = (rows >= 1) & (rows < height - 1) & (columns >= 1) & (columns < width - 1)
    places, rows, columns = ahead[inside], rows[inside], columns[inside]
    around = np.stack([seen_by.depth[rows + row, columns + column] for row, column in AROUND]) if len(places) else np.ones((9, 0))
    seen = (around > 0).any(axis=0)
    places, around = places[seen], around[:, seen]
    known = around > 0
    nearest, farthest = np.where(known, around, np.inf).min(axis=0), np.where(known, around, -np.inf).max(axis=0)
    own = away[places]
    beyond: np.ndarray = np.where(nearest > own, nearest - own, np.where(farthest < own, farthest - own, 0.0))
    return places, beyond, own


def grid_votes(mine: Sequence[Frame], seen_by: Sequence[Frame], constants: Joint, itself: bool = False) -> list[np.ndarray]:
    """For each frame of a tour the votes (2, h, w) of the frames of a tour on its grid: through, at.

    itself: the tours are one, and a frame has no vote on its own places.
    """
    found = []
    for number, one in enumerate(mine):
        others = [other for k, other in enumerate(seen_by) if not (itself and k == number)]
        said = votes(one.points[one.known], others, constants)
        grid = np.zeros((2, *one.known.shape), np.int64)
        grid[0][one.known], grid[1][one.known] = said.through, said.at
        found.append(grid)
    return found
