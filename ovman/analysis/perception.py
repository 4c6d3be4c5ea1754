"""Detections of the recorded tours against the true instances of their pictures: recall, precision, retrieval, place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ovman.analysis.backprojection import box_distance_m
from ovman.analysis.instances import match_views, read_of_scene, read_scenes
from ovman.analysis.rows import Row, write_csv
from ovman.language.vocabulary import nouns
from ovman.perception.records import Detected, read_detections, read_nouns
from ovman.records.episode import Episode
from ovman.records.scene import Scene, SceneObject
from ovman.records.visit import Visit, tour_path
from ovman.settings import Settings

STILL_M = 0.001
"""An object is where the scene's record has it if its box's centre is this close."""
SIZES_PX = (600, 1500, 5000)
"""Where the groups by size begin; the first begins with the smallest mask that counts."""
TOPS = (1, 5)
ALL, SIZE, SCENE, CATEGORY, CATEGORIES = "all", "size", "scene", "category", "categories"


@dataclass(frozen=True, slots=True)
class PerceptionScore:
    """The scores of a group of true instances and of masks; None if they do not apply.

    Attributes:
        true: True instances in single views; `recalled`: those found.
        found: Detected masks; `right`: those that show an instance; `doubled`: those whose instance a surer mask shows, which
            `precision` counts as right and `precision_once` as wrong.
        crops: Right masks whose category is retrieved: by its own noun (`top1`, `top5`), at chance, and for the `named` ones,
            whose category has synonyms, by its own noun (`own_`) and by the mean over synonyms.
        off_box_median_m: From the place of a right mask to its object's box; `off_box_p95_m`: the 95th percentile.
    """

    group: str
    value: str
    true: int | None = None
    recalled: int | None = None
    recall: float | None = None
    found: int | None = None
    right: int | None = None
    precision: float | None = None
    doubled: int | None = None
    precision_once: float | None = None
    crops: int | None = None
    top1: float | None = None
    top5: float | None = None
    chance_top1: float | None = None
    chance_top5: float | None = None
    named: int | None = None
    own_top1: float | None = None
    own_top5: float | None = None
    synonym_top1: float | None = None
    synonym_top5: float | None = None
    off_box_median_m: float | None = None
    off_box_p95_m: float | None = None


PERCEPTION = " ".join(field.name for field in fields(PerceptionScore))


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Tidy tables of tours.

    Attributes:
        true: One row per true instance and view: scene, category, px, recalled.
        masks: One row per mask: scene, category ("" if it shows no instance), px, doubled; for right masks top1, top5, chance_*,
            synonym_* (NaN without synonyms) and off_box_m (NaN if the object is not where the scene's record has it).
    """

    true: pd.DataFrame
    masks: pd.DataFrame


def write_perception(
    scene_files: Sequence[Path],
    detections: Sequence[Path],
    episode_files: Sequence[Path],
    nouns_file: Path,
    visits: Path,
    settings: Settings,
    output: Path,
) -> None:
    """Write perception.csv of the tours of the episodes. Visits of equal content count once.

    Settings: perception.detector.min_mask_px.
    """
    text, min_mask_px = read_nouns(nouns_file), settings.perception.detector.min_mask_px
    toured = {
        (one.scene, visit)
        for path in episode_files
        for one in Episode.load(path)
        for visit in (one.visits.first, one.visits.second)
    }
    seen = []
    for scene in read_scenes(scene_files):
        found = read_of_scene(detections, scene.scene, read_detections)
        if tours := distinct_tours({name: one for name, one in found.items() if (scene.scene, name) in toured}):
            seen.append(match_tours(scene, tours, text, visits / scene.scene, min_mask_px))
    rows = scores(Seen(*(pd.concat([getattr(one, name) for one in seen], ignore_index=True) for name in ("true", "masks"))))
    write_csv(output, PERCEPTION, rows)
    print(f"{rows[0].true} true masks, {rows[0].found} detected ones", flush=True)


def distinct_tours(tours: Mapping[str, Detected]) -> dict[str, Detected]:
    """Return the tours by the names of their visits, of those with equal content the first name only."""
    kept: dict[str, str] = {}
    for name in sorted(tours):
        kept.setdefault(tours[name].content, name)
    return {name: tours[name] for name in sorted(kept.values())}


def match_tours(
    scene: Scene, tours: Mapping[str, Detected], text: Mapping[str, np.ndarray], visits: Path, min_mask_px: int
) -> Seen:
    """Match the detections of a scene's tours with true instances, and rank the categories of the scene for each right mask."""
    categories = np.array([*(o.category for o in scene.objects), ""], object)
    true, masks, features = [], [], []
    for name, detected in tours.items():
        still = _still(scene, Visit.load(tour_path(visits, name)))
        for _, rows, part in match_views(scene, tour_path(visits, name), detected, min_mask_px):
            right = part.object >= 0
            off = np.full(len(rows), np.nan)
            for k in np.flatnonzero(right):
                if still[part.object[k]]:
                    off[k] = box_distance_m(detected.point[rows[k]], scene.objects[part.object[k]])
            true.append({"category": categories[part.true_object], "px": part.true_px, "recalled": part.recalled})
            masks.append({"category": categories[part.object], "px": part.px, "doubled": part.doubled, "off_box_m": off})
            features.append(detected.feature[rows[right]])
    tables = Seen(*(pd.concat(map(pd.DataFrame, parts), ignore_index=True).assign(scene=scene.scene) for parts in (true, masks)))
    shown = tables.masks["category"] != ""
    present = sorted({one.category for one in scene.objects})
    by_category = {category: nouns(category) for category in present}
    truly = tables.masks["category"][shown].tolist()
    found = rank_categories(np.concatenate(features), truly, present, by_category, text)
    for top in TOPS:
        for name, rank in (("top", found.top), ("chance_top", found.chance), ("synonym_top", found.top_by_synonym)):
            tables.masks.loc[shown, f"{name}{top}"] = rank(top)
    return tables


def _still(scene: Scene, visit: Visit) -> list[bool]:
    """Tell of every object of the scene whether it stays where the scene's record has it during a visit."""
    restless = {name for view in visit.views for name in view.moved}

    def is_still(one: SceneObject) -> bool:
        if one.id not in visit.present:
            return True
        here, there = visit.present[one.id].position, one.position
        gap = np.array([here.x, here.y, here.z]) - (there.x, there.y, there.z)
        return one.id not in restless and bool(np.linalg.norm(gap) <= STILL_M)

    return [is_still(one) for one in scene.objects]


def scores(seen: Seen) -> list[PerceptionScore]:
    """Score all masks, the mean over categories, then by size, scene and category.

    Sizes are those of the instances for recall and those of the masks for everything else.
    """
    true, masks = seen.true, seen.masks
    categories = sorted({*true["category"], *masks["category"]} - {""})
    by_category = [
        _score(CATEGORY, name, true[true["category"] == name], masks[masks["category"] == name], wrong=False)
        for name in categories
    ]
    rows = [_score(ALL, ALL, true, masks), _mean_over_categories(by_category)]
    for name, low, high in _sizes():
        of_true, of_masks = (some[(some["px"] >= low) & (some["px"] < high)] for some in (true, masks))
        rows.append(_score(SIZE, name, of_true, of_masks))
    for scene in dict.fromkeys([*true["scene"], *masks["scene"]]):
        rows.append(_score(SCENE, scene, true[true["scene"] == scene], masks[masks["scene"] == scene]))
    return rows + by_category


def _sizes() -> Iterator[tuple[str, float, float]]:
    yield f"below {SIZES_PX[0]} px", 0, SIZES_PX[0]
    for low, high in pairwise(SIZES_PX):
        yield f"{low}-{high - 1} px", low, high
    yield f"{SIZES_PX[-1]} px and more", SIZES_PX[-1], np.inf


def _score(group: str, value: str, true: pd.DataFrame, masks: pd.DataFrame, wrong: bool = True) -> PerceptionScore:
    """Score a group; `wrong` tells whether masks that show no instance can be in it."""
    is_right = masks["category"] != ""
    right = masks[is_right]
    named = right[right["synonym_top1"].notna()]
    off = right["off_box_m"].dropna().to_numpy()
    row: Row = {"true": len(true), "recalled": int(true["recalled"].sum()), "recall": _mean(true["recalled"])}
    row |= {"right": len(right), "doubled": int(masks["doubled"].sum()), "crops": len(right), "named": len(named)}
    row |= {name: _mean(right[name]) for name in ("top1", "top5", "chance_top1", "chance_top5")}
    row |= {name: _mean(named[name.removeprefix("own_")]) for name in ("own_top1", "own_top5", "synonym_top1", "synonym_top5")}
    if wrong:
        row |= {"found": len(masks), "precision": _mean(is_right), "precision_once": _mean(is_right & ~masks["doubled"])}
    if len(off):
        row |= {"off_box_median_m": float(np.median(off)), "off_box_p95_m": float(np.percentile(off, 95))}
    return PerceptionScore(group, value, **row)


def _mean_over_categories(rows: Sequence[PerceptionScore]) -> PerceptionScore:
    """Return the means of what the rows have; every category counts the same."""
    names = ("recall", *(f"{kind}{top}" for kind in ("top", "chance_top", "own_top", "synonym_top") for top in TOPS))
    means: Row = {name: _mean([value for row in rows if (value := getattr(row, name)) is not None]) for name in names}
    return PerceptionScore(CATEGORIES, "mean", **means)


def _mean(values: Sequence[float] | pd.Series[Any]) -> float | None:
    return float(np.mean(np.asarray(values))) if len(values) else None


@dataclass(frozen=True, slots=True, eq=False)
class Ranks:
    """Ranks of N crops. own (N,): how many categories come before the right one if each goes by its own noun; 0 is first.

    synonyms: per crop the same with each synonym of the right category instead of its own noun (S,); S is 0 for a
    category without synonyms. choices (N,): how many categories there were.
    """

    own: np.ndarray
    synonyms: tuple[np.ndarray, ...]
    choices: np.ndarray

    def top(self, k: int) -> np.ndarray:
        """Return (N,) 1.0 where the right category is among the first k."""
        return (self.own < k).astype(float)

    def top_by_synonym(self, k: int) -> np.ndarray:
        """Return (N,) the share of the synonyms by which the right category is among the first k; NaN without synonyms."""
        return np.array([np.mean(ranks < k) if len(ranks) else np.nan for ranks in self.synonyms])

    def chance(self, k: int) -> np.ndarray:
        """Return (N,) the expected value for a random order."""
        return np.minimum(k / self.choices, 1.0)


def rank_categories(
    features: np.ndarray,
    categories: Sequence[str],
    present: Sequence[str],
    nouns: Mapping[str, Sequence[str]],
    text: Mapping[str, np.ndarray],
) -> Ranks:
    """Rank the right categories of N crops, of true or of detected masks.

    features (N, K): unit embeddings of the crops, categories: what each shows; present: the categories to choose from. nouns: of
    each category, its own noun first, then the synonyms; text: unit embedding (K,) of every noun. A category that is as similar
    as the right one comes before it, unless it goes by the same phrase: a noun that several categories share is right for each.
    """
    order = sorted(set(present))
    features = np.asarray(features, float)
    of_noun = np.stack([text[nouns[category][0]] for category in order]).astype(float) if order else np.zeros((0, 0))
    own = np.zeros(len(features), int)
    by_synonym: list[np.ndarray] = [np.zeros(0, int)] * len(features)
    labels = np.array(categories, object)
    for category in sorted(set(categories)):
        rows = np.flatnonzero(labels == category)
        others = [i for i, other in enumerate(order) if other != category]
        against = features[rows] @ of_noun[others].T
        phrases = [nouns[order[i]][0] for i in others]

        before = partial(_count_before, features[rows], against, phrases, text)
        own[rows] = before(nouns[category][0])
        renamed = np.stack([before(phrase) for phrase in nouns[category][1:]] or [np.zeros(len(rows), int)], axis=1)
        for row, of_row in zip(rows, renamed[:, : len(nouns[category]) - 1], strict=True):
            by_synonym[row] = of_row
    return Ranks(own, tuple(by_synonym), np.full(len(features), len(order)))


def _count_before(
    features: np.ndarray, against: np.ndarray, phrases: Sequence[str], text: Mapping[str, np.ndarray], phrase: str
) -> np.ndarray:
    """Return (R,) how many other categories come before the right one, if that goes by `phrase`.

    features (R, K): of the crops; against (R, C): similarities to the nouns `phrases` of the C other categories.
    """
    rival = np.array([other != phrase for other in phrases], bool)
    ahead: np.ndarray = (against[:, rival] >= (features @ text[phrase].astype(float))[:, None]).sum(axis=1)
    return ahead
