"""Stage `labels`: what the detections of the recorded tours truly show. Diagnostic arms are handed their grounding by it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ovman.perception.detected import Detected
from ovman.perception.labels import NOTHING, Labels, categories_of, shown, write_labels
from ovman.perception.records import read_detections
from ovman.perception.tour_files import picture
from ovman.records.scene import Scene
from ovman.records.visit import Visit


def labels(seen: Detected, directory: Path, categories: dict[str, str], names: tuple[str, ...]) -> Labels:
    """What the detections of the tour recorded in `directory` truly show.

    categories: of the scene's instances, by their ids; names: the categories in the order of `Labels.categories`. TourError for a
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


def run(scenes: Sequence[Path], detections: Sequence[Path], visits: Path, outputs: Sequence[Path]) -> None:
    """Writes the labels of all visits of each file of detections, one file for each in their order.

    scenes: records of the stage "scenes", in the same order; visits: directory of the recorded visits of all scenes. A tour that
    several visits share is looked at once.
    """
    for scene_file, source, output in zip(scenes, detections, outputs, strict=True):
        scene = Scene.parse(scene_file.read_text(encoding="utf-8"), str(scene_file))
        categories = categories_of(scene)
        names = tuple(sorted({*categories.values()}))
        by_content: dict[str, Labels] = {}
        made = {}
        for name, seen in read_detections(source).items():
            if seen.content not in by_content:
                by_content[seen.content] = labels(seen, visits / scene.scene / name, categories, names)
            made[name] = by_content[seen.content]
        write_labels(output, made)
        every = np.concatenate([np.zeros(0, int), *(one.category for one in by_content.values())])
        share = float((every != NOTHING).mean()) if len(every) else 0.0
        print(
            f"{scene.scene}: {len(every)} detections in {len(by_content)} tours, {share:.2f} of them show an instance", flush=True
        )
