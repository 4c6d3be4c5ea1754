"""Stage `labels`: the instances that the detections of every tour truly show."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ovman.perception.labels import NOTHING, Labels, categories_of, shown, write_labels
from ovman.perception.records import Detected, read_detections
from ovman.perception.tour_files import picture
from ovman.processes import map_items
from ovman.records.scene import Scene
from ovman.records.visit import Visit


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
            by_content[seen.content] = label_tour(seen, visits / scene.scene / name, categories, names)
        by_visit[name] = by_content[seen.content]
    write_labels(output / f"{scene.scene}.npz", by_visit)
    every = np.concatenate([np.zeros(0, int), *(one.category for one in by_content.values())])
    share = float((every != NOTHING).mean()) if len(every) else 0.0
    print(f"{scene.scene}: {len(every)} detections in {len(by_content)} tours, {share:.2f} of them show an instance", flush=True)


def label_tour(seen: Detected, directory: Path, categories: dict[str, str], names: tuple[str, ...]) -> Labels:
    """Return the labels of the detections of the tour recorded in `directory`.

    categories: Of the scene's instances, by their ids. names: The categories in the order of `Labels.categories`. TourError for a
    file of the tour that is missing or damaged.
    """
    visit, masks = Visit.load(directory), seen.masks()
    category = np.full(len(seen), NOTHING, np.int64)
    for view, looked in enumerate(visit.views):
        rows = np.flatnonzero(seen.view == view)
        index = picture(directory / f"{view:02d}_ids.png").astype(np.int64) - 1
        for row, instance in zip(rows.tolist(), shown(masks[rows], index).tolist(), strict=True):
            name = categories.get(looked.instances[instance]) if instance != NOTHING else None
            if name is not None:
                category[row] = names.index(name)
    return Labels(names, category, seen.pixels)
