"""Compare masks with true instances. Labels are the evaluator's: of the arms, only those with oracle grounding get them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ovman.perception.array_file import read_arrays, write_arrays
from ovman.perception.detector import Detections, Detector
from ovman.perception.records import Detected, read_detections
from ovman.perception.tour_files import picture
from ovman.processes import map_items
from ovman.records.scene import Scene
from ovman.records.visit import Visit, tour_path

LABELS = "ovman-labels/1"
NOTHING = -1
SHELL = frozenset({"Floor"})
"""Categories of a scene's record that are not instances."""
LEAST_IOU = 0.5
"""Least IoU of a mask with the instance that it shows."""


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """True categories of the N detections of a tour, in their order.

    category (N,) int: index into `categories`, NOTHING for a mask that overlaps with no instance enough; pixels (N,) int: sizes
    of the masks.
    """

    categories: tuple[str, ...]
    category: np.ndarray
    pixels: np.ndarray

    def __len__(self) -> int:
        return len(self.category)


def shown(masks: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return the value of ids (H, W) int of the instance that each mask (N, H, W) bool shows; NOTHING below LEAST_IOU.

    Negative ids are not instances. Of two instances with equal IoU the one of smaller id is shown.
    """
    import pandas as pd  # a job that reads labels starts without it

    # Numbers of instances may be colours, so they are counted before they are matched.
    codes, values = pd.factorize(ids.ravel(), sort=True)
    negative = int(np.searchsorted(values, 0))
    iou, _ = intersection_over_union(masks, codes.reshape(ids.shape) - negative, len(values) - negative)
    best = np.pad(iou, ((0, 0), (1, 0))).argmax(axis=1)
    return np.where(iou.max(axis=1, initial=0.0) >= LEAST_IOU, np.array([NOTHING, *values[negative:]])[best], NOTHING)


def intersection_over_union(masks: np.ndarray, ids: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the IoU (N, count) of masks (N, H, W) bool with the instances of ids (H, W), and the instances' sizes (count,).

    ids: 0 ... count - 1, -1 outside of instances; sizes are in pixels.
    """
    sizes = np.bincount(ids[ids >= 0].ravel(), minlength=count)[:count]
    if not len(masks):
        return np.zeros((0, count)), sizes
    inter = np.stack([np.bincount(ids[mask & (ids >= 0)], minlength=count)[:count] for mask in masks])
    return inter / np.maximum(masks.sum(axis=(1, 2))[:, None] + sizes[None] - inter, 1), sizes


def categories_of(scene: Scene) -> dict[str, str]:
    """Return the category of every instance of a scene by its id."""
    return {o.id: o.category for o in scene.objects if o.category not in SHELL}


def write_labels(path: Path, visits: Mapping[str, Labels]) -> None:
    """Write the labels of visits by their names. All have the same categories."""
    every = list(visits.values())
    arrays = {
        "visits": np.array(list(visits), str),
        "detections": np.array([len(labels) for labels in every], np.int64),
        "categories": np.array(every[0].categories if every else (), str),
        "category": np.concatenate([np.zeros(0, np.int16), *(labels.category for labels in every)]).astype(np.int16),
        "pixels": np.concatenate([np.zeros(0, np.int32), *(labels.pixels for labels in every)]).astype(np.int32),
    }
    write_arrays(path, LABELS, arrays)


def read_labels(path: Path) -> dict[str, Labels]:
    """Read the labels of visits by their names. Raises ArrayFileError for a damaged file."""
    arrays = read_arrays(path, LABELS)
    ends = np.cumsum(arrays["detections"])
    categories = tuple(arrays["categories"].tolist())
    return {
        name: Labels(categories, arrays["category"][start:end], arrays["pixels"][start:end])
        for name, start, end in zip(arrays["visits"].tolist(), (ends - arrays["detections"]).tolist(), ends.tolist(), strict=True)
    }


class TrueMasks(Detector):
    """Give the true masks of what can be moved in a recorded tour, in the place of a detector's."""

    def __init__(self, tour: Path) -> None:
        """Prepare the masks of a tour. Raises as `label_tour`."""
        self._tour, self._visit = tour, Visit.load(tour)

    def detect(self, pictures: Sequence[np.ndarray]) -> list[Detections]:
        """Return the masks of each view; `pictures` are those of all views."""
        found = []
        for number, view in enumerate(self._visit.views[: len(pictures)]):
            values = [value for value, name in enumerate(view.instances, 1) if name in self._visit.present]
            masks = picture(self._tour, number, "ids") == np.reshape(values, (-1, 1, 1))
            found.append(Detections(masks, np.ones(len(values), np.float32)))
        return found


def run(scene_files: Sequence[Path], detections: Path, visits: Path, output: Path, workers: int = 1) -> None:
    """Write the labels of all visits of each scene that has detections, one file per scene."""
    scenes = [scene for file in scene_files for scene in Scene.read(file) if (detections / f"{scene.scene}.npz").is_file()]
    output.mkdir(parents=True, exist_ok=True)
    map_items(partial(label_scene, detections, visits, output), [scene.to_line() for scene in scenes], workers)


def label_scene(detections: Path, visits: Path, output: Path, scene_line: str) -> None:
    """Write the labels of all visits of a scene. A tour that several visits share is labelled once."""
    scene = Scene.parse(scene_line)
    categories = categories_of(scene)
    names = tuple(sorted({*categories.values()}))
    by_content: dict[str, Labels] = {}
    by_visit = {}
    for name, seen in read_detections(detections / f"{scene.scene}.npz").items():
        if seen.content not in by_content:
            by_content[seen.content] = label_tour(seen, tour_path(visits / scene.scene, name), categories, names)
        by_visit[name] = by_content[seen.content]
    write_labels(output / f"{scene.scene}.npz", by_visit)
    every = np.concatenate([np.zeros(0, int), *(one.category for one in by_content.values())])
    share = float((every != NOTHING).mean()) if len(every) else 0.0
    print(f"{scene.scene}: {len(every)} detections in {len(by_content)} tours, {share:.2f} of them show an instance", flush=True)


def label_tour(seen: Detected, tour: Path, categories: dict[str, str], names: tuple[str, ...]) -> Labels:
    """Return the labels of the detections of the recorded tour.

    categories: Of the scene's instances, by their ids. names: The categories in the order of `Labels.categories`. TourError for a
    file of the tour that is missing or damaged.
    """
    visit, masks = Visit.load(tour), seen.masks()
    category = np.full(len(seen), NOTHING, np.int64)
    for view, looked in enumerate(visit.views):
        rows = np.flatnonzero(seen.view == view)
        index = picture(tour, view, "ids").astype(np.int64) - 1
        for row, instance in zip(rows.tolist(), shown(masks[rows], index).tolist(), strict=True):
            name = categories.get(looked.instances[instance]) if instance != NOTHING else None
            if name is not None:
                category[row] = names.index(name)
    return Labels(names, category, seen.pixels)
