"""The stage "perception": what was detected in the recorded tours, against the true instances of their pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ovman.analysis import frames
from ovman.analysis.instances import TrueScene, true_ids
from ovman.analysis.localisation import box_distance_m
from ovman.analysis.scores import Score, Seen, scores
from ovman.analysis.segmentation import Segmented, joined, segmented
from ovman.language.vocabulary import nouns
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, read_nouns
from ovman.perception.retrieval import ranks
from ovman.records.episode import Episode
from ovman.records.visit import Visit
from ovman.settings import Settings

STILL_M = 0.001
"""An object is where the scene's record has it if its box's centre is this close."""


def run(
    scenes: Sequence[Path],
    detections: Sequence[Path],
    episodes: Sequence[Path],
    nouns_file: Path,
    visits: Path,
    constants: Settings,
    output: Path,
) -> None:
    """Writes the rows of `scores`. Each distinct tour counts once: visits of equal content were seen once.

    scenes: records of the stage "scenes"; detections: files of the stage "detections", named after the scenes; episodes:
    whose tours are looked at, a file a split; visits: the
    directory of the recorded visits. constants: perception.detector.min_mask_px.
    A scene that no episode uses has no tours and no row. Raises ValueError in one line for a scene without a file of detections.
    """
    of_scene = {path.stem: path for path in detections}
    text = read_nouns(nouns_file)
    pairs = {(one.scene, one.visits) for path in episodes for one in Episode.load(path)}
    toured = {(scene, name) for scene, both in pairs for name in (both.first, both.second)}
    seen = []
    for path in scenes:
        scene = TrueScene.load(path)
        if scene.name not in of_scene:
            raise ValueError(f"{scene.name}: no file of detections; make it first: results/detections/{scene.name}.npz")
        looked_at = read_detections(of_scene[scene.name])
        tours = distinct({name: one for name, one in looked_at.items() if (scene.name, name) in toured})
        if tours:
            seen.append(seen_in(scene, tours, text, visits / scene.name, constants.perception.detector.min_mask_px))
    rows = scores(seen)
    frames.write(output, Score, rows)
    whole = rows[0]
    print(f"{sum(one.tours for one in seen)} tours: {whole.true} true masks, {whole.found} detected ones", flush=True)


def distinct(tours: Mapping[str, Detected]) -> dict[str, Detected]:
    """The tours by their visits' names, of those with equal content the first name only."""
    kept: dict[str, str] = {}
    for name in sorted(tours):
        kept.setdefault(tours[name].content, name)
    return {name: tours[name] for name in sorted(kept.values())}


def seen_in(
    scene: TrueScene, tours: Mapping[str, Detected], text: Mapping[str, np.ndarray], visits: Path, min_mask_px: int
) -> Seen:
    """What the detections of a scene's tours show. text: unit embedding of every noun; visits: the scene's recorded visits.

    The categories to choose from are those of all objects of the scene, whether the tour shows them or not.
    """
    parts: list[Segmented] = []
    features, off = [], []
    for name, detected in tours.items():
        visit = Visit.load(visits / name)
        masks, still = detected.masks(), _still(scene, visit)
        for view in range(len(visit.views)):
            rows = np.flatnonzero(detected.view == view)
            ids = true_ids(scene, visit, visits / name, view)
            part = segmented(masks[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px)
            right = part.object >= 0
            parts.append(part)
            features.append(detected.feature[rows[right]])
            off += [
                box_distance_m(detected.point[row], scene.objects[index]) if still[index] else np.nan
                for row, index in zip(rows[right], part.object[right], strict=True)
            ]
    whole = joined(parts)
    categories = tuple(o.category for o in scene.objects)
    shown = [categories[index] for index in whole.object[whole.object >= 0]]
    by_category = {category: nouns(category) for category in scene.categories}
    named = ranks(np.concatenate(features), shown, scene.categories, by_category, text)
    return Seen(scene.name, len(tours), categories, whole, named, np.array(off))


def _still(scene: TrueScene, visit: Visit) -> list[bool]:
    """Of every object of the scene, whether it stays where the scene's record has it during a visit."""
    restless = {name for view in visit.views for name in view.moved}

    def still(name: str, centre: tuple[float, float, float]) -> bool:
        if name not in visit.present:
            return True
        place = visit.present[name].position
        gap = np.linalg.norm(np.array([place.x, place.y, place.z]) - centre)
        return name not in restless and bool(gap <= STILL_M)

    return [still(o.id, o.centre) for o in scene.objects]
