"""Where back-projected masks lie and where their objects are: the self-check of Eq. backproj, one row per mask."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ovman.analysis.instances import match_masks, read_of_scene, read_scenes, true_ids
from ovman.analysis.rows import Row, write_csv
from ovman.perception.backprojection import Camera, median_point, single_ray_point
from ovman.perception.records import Detected, read_detections
from ovman.perception.tour_files import picture
from ovman.records.geometry import Position
from ovman.records.scene import Scene, SceneObject
from ovman.records.visit import MILLIMETRES, Visit, tour_path
from ovman.settings import Settings

BACKPROJECTION = "scene object category view mask px median_box_m median_centre_m ray_box_m ray_centre_m"
UNTOUCHED = "untouched"
TRUE, DETECTED = "true", "detected"
"""Where a mask comes from."""


def write_backprojection(
    scene_files: Sequence[Path], detections: Sequence[Path], visits: Path, settings: Settings, output: Path
) -> None:
    """Write one row per mask of the untouched tours, true and detected ones.

    The untouched tour has detections if an episode uses it. Settings: camera.field_of_view_deg, perception.detector.min_mask_px.
    """
    rows: list[Row] = []
    for scene in read_scenes(scene_files):
        detected = read_of_scene(detections, scene.scene, read_detections).get(UNTOUCHED)
        tour, min_mask_px = tour_path(visits / scene.scene, UNTOUCHED), settings.perception.detector.min_mask_px
        rows += locate_masks(scene, tour, settings.camera.field_of_view_deg, min_mask_px, detected)
    write_csv(output, BACKPROJECTION, rows)
    print(f"{len(rows)} masks of {len({(row['scene'], row['object']) for row in rows})} objects", flush=True)


def locate_masks(
    scene: Scene, tour: Path, field_of_view_deg: float, min_mask_px: int, detected: Detected | None
) -> Iterator[Row]:
    """Yield every true mask of at least `min_mask_px` of the untouched visit, then the detected ones that show an instance.

    box: distance from the estimated place to the object's axis-aligned box, 0 inside; centre: to the box's centre on the floor
    plane. median: the component-wise median of the mask's points; ray: the ray through the middle of the mask at median depth.

    Raises:
        ValueError: Something moves in the visit, so the boxes of the scene's record do not hold.
    """
    visit = Visit.load(tour)
    if visit.alterations or any(view.moved for view in visit.views):
        raise ValueError(f"{tour}: something moves in this visit; the boxes of {scene.scene} are those of the untouched one")
    found = np.zeros((0, 0, 0), bool) if detected is None else detected.masks()
    for number, view in enumerate(visit.views):
        ids, place, pose = true_ids(scene, visit, tour, number), view.camera, view.pose
        depth_m = picture(tour, number, "depth") / MILLIMETRES
        camera = Camera((place.x, place.y, place.z), pose.yaw_deg, pose.horizon_deg, field_of_view_deg)
        for index in np.unique(ids[ids >= 0]):
            mask = ids == index
            if mask.sum() >= min_mask_px:
                yield _row(scene, scene.objects[index], number, TRUE, mask, depth_m, camera)
        if detected is not None:
            rows = np.flatnonzero(detected.view == number)
            shown = match_masks(found[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px).object
            for row, index in zip(rows[shown >= 0], shown[shown >= 0], strict=True):
                yield _row(scene, scene.objects[index], number, DETECTED, found[row], depth_m, camera)


def _row(scene: Scene, thing: SceneObject, view: int, kind: str, mask: np.ndarray, depth_m: np.ndarray, camera: Camera) -> Row:
    points = median_point(depth_m, mask, camera), single_ray_point(depth_m, mask, camera)
    errors = [distance(point, thing) for point in points for distance in (box_distance_m, centre_distance_m)]
    return dict(
        zip(BACKPROJECTION.split(), (scene.scene, thing.id, thing.category, view, kind, int(mask.sum()), *errors), strict=True)
    )


def box_distance_m(point: np.ndarray, thing: SceneObject) -> float:
    """Return the distance from a point (3,) to an object's axis-aligned box, 0 inside, metres."""
    beyond = np.abs(point - _vector(thing.position)) - _vector(thing.size) / 2
    return float(np.linalg.norm(np.maximum(beyond, 0.0)))


def centre_distance_m(point: np.ndarray, thing: SceneObject) -> float:
    """Return the distance from a point (3,) to the centre of an object's box on the floor plane, metres."""
    return float(np.hypot(point[0] - thing.position.x, point[2] - thing.position.z))


def _vector(position: Position) -> np.ndarray:
    return np.array([position.x, position.y, position.z])
