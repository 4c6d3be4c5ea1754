"""What DynaMem takes from a frame: points with features, and what its detections show."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ovman.agents.dynamem.settings import Dynamem
from ovman.agents.interface import Visit
from ovman.perception.backprojection import Camera, pixel_points
from ovman.perception.detected import Detected


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A frame with its D detections.

    depth (H, W): metres along the optical axis; camera: of the frame; masked (H, W) bool: pixels of a detection; points (N, 3):
    world points in metres, of (N,): the detection that each is of, a pixel of two detections being two points; features (D, K):
    unit embeddings; places (D, 3): medians of the masks' world points, metres; nearest_m (D,): least depth of each mask.
    """

    depth: np.ndarray
    camera: Camera
    masked: np.ndarray
    points: np.ndarray
    of: np.ndarray
    features: np.ndarray
    places: np.ndarray
    nearest_m: np.ndarray

    def projected(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Where world points (N, 3) lie in the picture: rows (N,), columns (N,), depths (N,) in metres, and which are inside.

        Row and column of a point outside are 0.
        """
        height, width = self.depth.shape
        aside, up, away = ((points - np.array(self.camera.position)) @ self.camera.axes()).T
        focal_px = height / 2 / math.tan(math.radians(self.camera.field_of_view_deg) / 2)
        ahead = np.where(away > 0, away, np.inf)
        rows, columns = height / 2 - focal_px * up / ahead, width / 2 + focal_px * aside / ahead
        inside = (away > 0) & (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        row, column = (np.where(inside, at, 0).astype(np.int64) for at in (rows, columns))
        return row, column, away, inside


def looks(visit: Visit, detected: Detected, constants: Dynamem) -> tuple[Look, ...]:
    """The frames of a visit with their detections. ValueError for a tour without pictures."""
    if not len(visit.observations):
        return ()
    every = detected.masks()
    found = []
    for number, frame in enumerate(visit.observations):
        if frame.depth is None:
            raise ValueError("DynaMem reads depth; write needs: [tours, detections] in its entry")
        pose = frame.pose
        camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, frame.field_of_view_deg)
        mine = detected.view == number
        found.append(look(frame.depth, camera, every[mine], detected.feature[mine], detected.point[mine], constants))
    return tuple(found)


def look(
    depth: np.ndarray, camera: Camera, masks: np.ndarray, features: np.ndarray, places: np.ndarray, constants: Dynamem
) -> Look:
    """A frame of depth (H, W) with the masks (D, H, W) bool, features (D, K) and places (D, 3) of its detections.

    Of the pixels of a mask those at every n-th row and column become points whose depth is within the range and close to the
    median of the pixels around it.
    """
    rows, columns = (np.arange(constants.every_px // 2, side, constants.every_px) for side in depth.shape)
    steady = np.zeros((len(rows), len(columns)), bool)
    seen = masks[:, rows[:, None], columns[None, :]]
    asked = seen.any(axis=0)
    at = rows[np.nonzero(asked)[0]], columns[np.nonzero(asked)[1]]
    steady[asked] = _steady(depth, *at, constants)
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


def _steady(depth: np.ndarray, rows: np.ndarray, columns: np.ndarray, constants: Dynamem) -> np.ndarray:
    """(N,) which of N pixels have a depth within the range, close to the median of the square around them."""
    half = constants.median_px // 2
    around = np.lib.stride_tricks.sliding_window_view(np.pad(depth, half, mode="symmetric"), (constants.median_px,) * 2)
    own = depth[rows, columns]
    median = np.median(around[rows, columns].reshape(len(rows), constants.median_px**2), axis=1)
    within = (own > constants.nearest_m) & (own < constants.farthest_m)
    steady: np.ndarray = within & (np.abs(own - median) < constants.median_error_m)
    return steady
