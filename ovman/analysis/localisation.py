"""Where back-projected masks lie against where their objects are: the self-check of Eq. backproj."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ovman.analysis.instances import TrueObject, TrueScene, depth_m, true_ids
from ovman.analysis.segmentation import DETECTED, TRUE, segmented
from ovman.perception.backprojection import Camera, median_point, single_ray_point
from ovman.records.visit import Visit

if TYPE_CHECKING:
    from ovman.perception.detected import Detected


@dataclass(frozen=True, slots=True)
class Localised:
    """One mask of an untouched tour, and how far two estimates of its place are off, metres.

    mask: TRUE or DETECTED. box: distance to the object's axis-aligned box, 0 inside; centre: distance to the box's centre on the
    floor plane. median: the component-wise median of the mask's points; ray: the single ray through the middle of the mask at
    its median depth.
    """

    scene: str
    object: str
    category: str
    view: int
    mask: str
    px: int
    median_box_m: float
    median_centre_m: float
    ray_box_m: float
    ray_centre_m: float


def box_distance_m(point: np.ndarray, thing: TrueObject) -> float:
    """From a point (3,) to an object's axis-aligned box, 0 inside, metres."""
    beyond = np.abs(point - np.array(thing.centre)) - np.array(thing.size) / 2
    return float(np.linalg.norm(np.maximum(beyond, 0.0)))


def centre_distance_m(point: np.ndarray, thing: TrueObject) -> float:
    """From a point (3,) to the centre of an object's box on the floor plane, metres."""
    return float(np.hypot(point[0] - thing.centre[0], point[2] - thing.centre[2]))


def localised(
    scene: TrueScene, directory: Path, field_of_view_deg: float, min_mask_px: int, detected: Detected | None
) -> Iterator[Localised]:
    """The masks of the untouched visit recorded in `directory`, in the order of the tour: every true one of at least
    `min_mask_px`, then those of `detected` that show an instance.

    The boxes are those of the scene's record, so nothing may have moved: ValueError for a visit with changes.
    """
    visit = Visit.load(directory)
    if visit.alterations or any(view.moved for view in visit.views):
        raise ValueError(f"{directory}: something moves in this visit; the boxes of {scene.name} are those of the untouched one")
    found = np.zeros((0, 0, 0), bool) if detected is None else detected.masks()
    for number, view in enumerate(visit.views):
        ids, depth, pose = true_ids(scene, visit, directory, number), depth_m(directory, number), view.pose
        place = view.camera
        camera = Camera((place.x, place.y, place.z), pose.yaw_deg, pose.horizon_deg, field_of_view_deg)
        for index in np.unique(ids[ids >= 0]):
            mask = ids == index
            if mask.sum() >= min_mask_px:
                yield _localised(scene, scene.objects[index], number, TRUE, mask, depth, camera)
        if detected is not None:
            rows = np.flatnonzero(detected.view == number)
            shown = segmented(found[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px).object
            for row, index in zip(rows[shown >= 0], shown[shown >= 0], strict=True):
                yield _localised(scene, scene.objects[index], number, DETECTED, found[row], depth, camera)


def _localised(
    scene: TrueScene, thing: TrueObject, view: int, kind: str, mask: np.ndarray, depth: np.ndarray, camera: Camera
) -> Localised:
    points = median_point(depth, mask, camera), single_ray_point(depth, mask, camera)
    errors = [distance(point, thing) for point in points for distance in (box_distance_m, centre_distance_m)]
    return Localised(scene.name, thing.id, thing.category, view, kind, int(mask.sum()), *errors)
