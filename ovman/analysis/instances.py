"""The true instances of recorded tours: what every pixel shows, where objects are, and which instance a detected mask shows.

The room's shell is not an instance: walls and ceilings have no entry in the record of a scene, and the floor is left out here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from ovman.perception.labels import LEAST_IOU, SHELL, intersection_over_union
from ovman.perception.records import Detected
from ovman.perception.tour_files import picture
from ovman.records.scene import Scene
from ovman.records.visit import Visit

Content = TypeVar("Content")


def read_scenes(files: Iterable[Path]) -> list[Scene]:
    """Read files with one scene per line, each scene once and without its shell."""
    scenes = {scene.scene: scene for file in files for scene in Scene.read(file)}
    return [
        scene.model_copy(update={"objects": tuple(one for one in scene.objects if one.category not in SHELL)})
        for scene in scenes.values()
    ]


def scene_files(paths: Iterable[Path]) -> list[Path]:
    """Return files that are named after scenes, with directories replaced by the files in them."""
    return [file for path in paths for file in (sorted(path.glob("*.npz")) if path.is_dir() else [path])]


def read_of_scene(paths: Iterable[Path], scene: str, read: Callable[[Path], dict[str, Content]]) -> dict[str, Content]:
    """Read the visits of a scene from files that are named after scenes, or from directories of such files."""
    return {name: one for file in scene_files(paths) if file.stem == scene for name, one in read(file).items()}


def true_ids(scene: Scene, visit: Visit, tour: Path, view: int) -> np.ndarray:
    """Return the object of each pixel (H, W) of a recorded view as an index into the scene's objects, -1 for none, int32.

    TourError names an image that is missing or damaged.
    """
    place = {one.id: number for number, one in enumerate(scene.objects)}
    # The image has 0 for nothing and k for the k-th instance of the view.
    table = np.array([-1, *(place.get(name, -1) for name in visit.views[view].instances)], np.int32)
    ids: np.ndarray = table[picture(tour, view, "ids")]
    return ids


@dataclass(frozen=True, slots=True, eq=False)
class Segmented:
    """T true instances in single views, and N detected masks; indices are into a scene's objects.

    Attributes:
        true_object: (T,) every instance that is large enough, its size `true_px` and whether it is `recalled`.
        px: (N,) size of each mask.
        object: (N,) what each mask shows, -1 if it overlaps with no instance enough.
        doubled: (N,) whether a mask of higher confidence in the same view shows the same instance.
    """

    true_object: np.ndarray
    true_px: np.ndarray
    recalled: np.ndarray
    px: np.ndarray
    object: np.ndarray
    doubled: np.ndarray


def match_masks(masks: np.ndarray, confidence: np.ndarray, ids: np.ndarray, count: int, min_mask_px: int) -> Segmented:
    """Match the masks (N, H, W) bool of one view with the true instances.

    ids: (H, W), numbers of `count` objects, -1 for none of them. A true instance counts from `min_mask_px` on; a mask on a
    smaller one is right, too.
    """
    iou, sizes = intersection_over_union(masks, ids, count)
    true = np.flatnonzero(sizes >= min_mask_px)
    recalled = iou[:, true].max(axis=0, initial=0.0) >= LEAST_IOU
    shown = np.full(len(masks), -1)
    if count and len(masks):
        best = iou.argmax(axis=1)
        right = iou[np.arange(len(masks)), best] >= LEAST_IOU
        shown[right] = best[right]
    doubled = np.zeros(len(masks), bool)
    met: set[int] = set()
    for n in np.argsort(-np.asarray(confidence), kind="stable"):
        if shown[n] >= 0:
            doubled[n] = int(shown[n]) in met
            met.add(int(shown[n]))
    return Segmented(true, sizes[true], recalled, masks.sum(axis=(1, 2)), shown, doubled)


def match_views(scene: Scene, tour: Path, detected: Detected, min_mask_px: int) -> Iterator[tuple[int, np.ndarray, Segmented]]:
    """Yield each view of a recorded tour with the rows of its detections, and these matched as `match_masks` does."""
    visit, masks = Visit.load(tour), detected.masks()
    for view in range(len(visit.views)):
        rows = np.flatnonzero(detected.view == view)
        ids = true_ids(scene, visit, tour, view)
        yield view, rows, match_masks(masks[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px)


def shown_objects(scene: Scene, tour: Path, detected: Detected, min_mask_px: int) -> np.ndarray:
    """Return (N,) what each detection of a recorded tour shows, an index into the scene's objects, -1 for none of them."""
    shown = np.full(len(detected), -1)
    for _, rows, part in match_views(scene, tour, detected, min_mask_px):
        shown[rows] = part.object
    return shown
