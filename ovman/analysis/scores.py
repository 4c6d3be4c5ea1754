"""Scores of perception: recall, precision, retrieval and place of detected masks, of all and by group."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ovman.analysis.segmentation import Segmented
from ovman.perception.retrieval import Ranks

SIZES_PX = (600, 1500, 5000)
"""Where the groups by size begin; the first begins with the smallest mask that counts."""
FIRST, FEW = 1, 5
ALL, SIZE, SCENE, CATEGORY, CATEGORIES = "all", "size", "scene", "category", "categories"


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What perception made of the tours of one scene.

    segmented: its objects are indices into `categories`, the category of every object of the scene. ranks and off_box_m (M,) are
    of the M right masks, those that show an object, in their order; off_box_m: from a mask's place to its object's box, metres,
    NaN where the object is not where the scene's record has it.
    """

    scene: str
    tours: int
    categories: tuple[str, ...]
    segmented: Segmented
    ranks: Ranks
    off_box_m: np.ndarray


@dataclass(frozen=True, slots=True)
class Score:
    """One row: the members of a group. What does not apply is None.

    true, recalled: true instances in single views, and how many were found. found, right: detected masks, and how many show an
    instance; doubled: how many of those show one that a mask of higher confidence shows, which precision counts as right and
    precision_once as wrong. crops: right masks whose category was looked for;
    named: those whose category has synonyms, on which own_* and synonym_* are compared. chance_*: guessing. off_box_*: from the
    place of a right mask to its object's box, metres.
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


@dataclass(frozen=True, slots=True, eq=False)
class _Pool:
    """All scenes as columns: true instances, masks, and the right ones among the masks."""

    true_scene: np.ndarray
    true_category: np.ndarray
    true_px: np.ndarray
    recalled: np.ndarray
    scene: np.ndarray
    category: np.ndarray
    px: np.ndarray
    doubled: np.ndarray
    crop: dict[str, np.ndarray]


def scores(seen: Sequence[Seen]) -> list[Score]:
    """All together, the mean over categories, then by size, by scene in the order given, and by category. Sizes are those of the
    instances for recall and those of the masks for everything else."""
    pool = _pooled(seen)
    rows = [_score(pool, ALL, ALL, np.ones(len(pool.true_px), bool), np.ones(len(pool.px), bool))]
    categories = sorted({*pool.true_category, *pool.category} - {""})
    by_category = [
        _score(pool, CATEGORY, name, pool.true_category == name, pool.category == name, wrong=False) for name in categories
    ]
    rows.append(_mean(by_category))
    for name, low, high in _sizes():
        true, mask = ((column >= low) & (column < high) for column in (pool.true_px, pool.px))
        rows.append(_score(pool, SIZE, name, true, mask))
    for one in seen:
        rows.append(_score(pool, SCENE, one.scene, pool.true_scene == one.scene, pool.scene == one.scene))
    return rows + by_category


def _sizes() -> Iterator[tuple[str, float, float]]:
    yield f"below {SIZES_PX[0]} px", 0, SIZES_PX[0]
    for low, high in pairwise(SIZES_PX):
        yield f"{low}-{high - 1} px", low, high
    yield f"{SIZES_PX[-1]} px and more", SIZES_PX[-1], np.inf


def _pooled(seen: Sequence[Seen]) -> _Pool:
    def column(values: Sequence[ArrayLike], kind: type) -> np.ndarray:
        return np.concatenate([np.asarray(value, kind) for value in values]) if values else np.zeros(0, kind)

    def category(one: Seen, objects: np.ndarray) -> list[str]:
        return [one.categories[index] if index >= 0 else "" for index in objects]

    measures: dict[str, Callable[[Seen], np.ndarray]] = {
        "top1": lambda one: one.ranks.top(FIRST),
        "top5": lambda one: one.ranks.top(FEW),
        "chance_top1": lambda one: one.ranks.chance(FIRST),
        "chance_top5": lambda one: one.ranks.chance(FEW),
        "synonym_top1": lambda one: one.ranks.top_by_synonym(FIRST),
        "synonym_top5": lambda one: one.ranks.top_by_synonym(FEW),
        "off_box_m": lambda one: one.off_box_m,
    }
    pool = _Pool(
        true_scene=column([[one.scene] * len(one.segmented.true_px) for one in seen], object),
        true_category=column([category(one, one.segmented.true_object) for one in seen], object),
        true_px=column([one.segmented.true_px for one in seen], int),
        recalled=column([one.segmented.recalled for one in seen], bool),
        scene=column([[one.scene] * len(one.segmented.px) for one in seen], object),
        category=column([category(one, one.segmented.object) for one in seen], object),
        px=column([one.segmented.px for one in seen], int),
        doubled=column([one.segmented.doubled for one in seen], bool),
        crop={name: np.full(sum(len(one.segmented.px) for one in seen), np.nan) for name in measures},
    )
    shown = pool.category != ""
    for name, measure in measures.items():
        pool.crop[name][shown] = column([measure(one) for one in seen], float)
    return pool


def _score(pool: _Pool, group: str, value: str, true: np.ndarray, mask: np.ndarray, wrong: bool = True) -> Score:
    """Of the true instances `true` and the masks `mask`; `wrong`: whether masks that show no instance can be in the group."""
    right = mask & (pool.category != "")
    crop = {name: column[right] for name, column in pool.crop.items()}
    named = ~np.isnan(crop["synonym_top1"])
    off = crop["off_box_m"][~np.isnan(crop["off_box_m"])]
    return Score(
        group=group,
        value=value,
        true=int(true.sum()),
        recalled=int(pool.recalled[true].sum()),
        recall=_rate(pool.recalled[true]),
        found=int(mask.sum()) if wrong else None,
        right=int(right.sum()),
        precision=_rate(right[mask]) if wrong else None,
        doubled=int(pool.doubled[mask].sum()),
        precision_once=_rate((right & ~pool.doubled)[mask]) if wrong else None,
        crops=int(right.sum()),
        top1=_rate(crop["top1"]),
        top5=_rate(crop["top5"]),
        chance_top1=_rate(crop["chance_top1"]),
        chance_top5=_rate(crop["chance_top5"]),
        named=int(named.sum()),
        own_top1=_rate(crop["top1"][named]),
        own_top5=_rate(crop["top5"][named]),
        synonym_top1=_rate(crop["synonym_top1"][named]),
        synonym_top5=_rate(crop["synonym_top5"][named]),
        off_box_median_m=float(np.median(off)) if len(off) else None,
        off_box_p95_m=float(np.percentile(off, 95)) if len(off) else None,
    )


def _mean(rows: Sequence[Score]) -> Score:
    """Every category counting the same: the means of what the rows have."""

    def mean(name: str) -> float | None:
        return _rate([getattr(row, name) for row in rows if getattr(row, name) is not None])

    return Score(
        CATEGORIES,
        "mean",
        recall=mean("recall"),
        top1=mean("top1"),
        top5=mean("top5"),
        chance_top1=mean("chance_top1"),
        chance_top5=mean("chance_top5"),
        own_top1=mean("own_top1"),
        own_top5=mean("own_top5"),
        synonym_top1=mean("synonym_top1"),
        synonym_top5=mean("synonym_top5"),
    )


def _rate(values: Sequence[float] | np.ndarray) -> float | None:
    return float(np.mean(values)) if len(values) else None
