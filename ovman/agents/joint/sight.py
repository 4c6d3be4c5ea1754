"""What the frames of a tour show at places: something there, or through to what lies behind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ovman.agents.interface import Observation, Visit
from ovman.agents.joint.settings import Joint
from ovman.perception.backprojection import Camera, pixel_points

NEAREST_M = 0.2
"""What is nearer to a camera than this, or behind it, is not in its picture."""
AROUND_PX = 3
"""Side of the square around a pixel of which some depth may be the place's."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame and its grid of every n-th pixel, h rows of w.

    nearest, farthest (H, W): least and greatest depth around a pixel, metres along the optical axis, inf and -inf where none is
    known; rows (h,), columns (w,): of the grid's pixels; points (h, w, 3): where they lie in the world, metres; known (h, w)
    bool: whether they have depth.
    """

    nearest: np.ndarray
    farthest: np.ndarray
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
    known = depth > 0
    around = np.ones((AROUND_PX, AROUND_PX))
    nearest, farthest = cv2.erode(np.where(known, depth, np.inf), around), cv2.dilate(np.where(known, depth, -np.inf), around)
    return Frame(nearest, farthest, camera, rows, columns, points, known[at[0], at[1]])


def votes(points: np.ndarray, seen_by: Iterable[Frame], constants: Joint) -> Votes:
    """The votes of frames on places (N, 3), metres.

    A frame sees through a place where everything around its pixel is farther by more than the tolerance, and something at it
    where some of that is within the tolerance. Depth and poses err the more, the farther away a place is, and so grows the
    tolerance.
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
    away they are, metres. Of the depths around a place's pixel the one nearest to its own counts, 0 if it lies among them."""
    height, width = seen_by.nearest.shape
    aside, up, away = ((points - np.array(seen_by.camera.position)) @ seen_by.camera.axes()).T
    ahead = np.flatnonzero(away > NEAREST_M)
    focal_px = height / 2 / math.tan(math.radians(seen_by.camera.field_of_view_deg) / 2)
    rows = np.floor(height / 2 - focal_px * up[ahead] / away[ahead]).astype(np.int64)
    columns = np.floor(width / 2 + focal_px * aside[ahead] / away[ahead]).astype(np.int64)
    inside = (rows >= 1) & (rows < height - 1) & (columns >= 1) & (columns < width - 1)
    places, rows, columns = ahead[inside], rows[inside], columns[inside]
    nearest, farthest, own = seen_by.nearest[rows, columns], seen_by.farthest[rows, columns], away[places]
    beyond = np.where(nearest > own, nearest - own, np.minimum(farthest - own, 0.0))
    seen = np.isfinite(beyond)
    return places[seen], beyond[seen], own[seen]


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
