"""The table of perception, what is found and named in the recorded tours, and the bars that its rates should reach."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pandas as pd

from ovman.analysis.frames import rows_of
from ovman.analysis.scores import ALL, CATEGORIES, CATEGORY, SCENE, SIZE, Score
from ovman.perception.overlap import LEAST_IOU
from ovman.report.tables.columns import numbers, three, words
from ovman.report.tables.table import CSV_AND_MARKDOWN, SECTION, Table
from ovman.settings import Settings

RATES = ("recall", "precision", "precision_once", "top1", "top5", "synonym_top1", "synonym_top5")
_COUNTS = ("true", "found", "doubled", "crops")
_SECTIONS = {ALL: "all scenes", CATEGORIES: "all scenes", SIZE: "by size of the mask", SCENE: "by scene"}
_NAMES = {ALL: "all", CATEGORIES: "mean over categories"}


@dataclass(frozen=True, slots=True)
class Bar:
    """What a rate of all scenes should reach: at least `least`; `reached` is what it is."""

    rate: str
    least: float
    reached: float

    @property
    def met(self) -> bool:
        """Whether the rate reaches the bar."""
        return self.reached >= self.least

    @property
    def verdict(self) -> str:
        """The same in words."""
        return "met" if self.met else "not met"


LEAST = {"recall": 0.75, "precision": 0.75, "precision_once": 0.75, "top1": 0.60, "top5": 0.88}
SYNONYMS_BELOW = 0.10
"""Synonyms may be worse than the own nouns of the same categories by this much."""


def bars(scores: Sequence[Score]) -> dict[str, Bar]:
    """The bars by the name of their rate. A rate that is None, for want of masks, reaches nothing.

    Raises ValueError if there is no row of all masks.
    """
    whole = _whole(scores)
    least = {**LEAST, **{f"synonym_{top}": _value(whole, f"own_{top}") - SYNONYMS_BELOW for top in ("top1", "top5")}}
    return {rate: Bar(rate, least[rate], _value(whole, rate, -math.inf)) for rate in RATES}


def by_category(scores: Iterable[Score]) -> list[Score]:
    """The rows of single categories, those with the most true masks first."""
    return sorted((one for one in scores if one.group == CATEGORY), key=lambda one: (-(one.true or 0), one.value))


def perception_table(rows: pd.DataFrame, settings: Settings) -> Table:
    """All scenes with the bars, then by size and by scene. rows: of `Score`.

    Raises ValueError if there is no row of all masks.
    """
    scores = rows_of(Score, rows)
    whole, checked = _whole(scores), bars(scores)
    all_scenes = {SECTION: _SECTIONS[ALL], "of": _SECTIONS[ALL]}
    shown = [
        _row(whole),
        *(_row(one) for one in scores if one.group == CATEGORIES),
        {**all_scenes, "which": "chance", "top1": whole.chance_top1, "top5": whole.chance_top5},
        {**all_scenes, "which": "bar", **{rate: f"≥ {three(bar.least)}" for rate, bar in checked.items()}},
        {**all_scenes, "which": "verdict", **{rate: bar.verdict for rate, bar in checked.items()}},
        *(_row(one) for group in (SIZE, SCENE) for one in scores if one.group == group),
    ]
    detector = settings.perception.detector
    columns = (
        words("of", formats=CSV_AND_MARKDOWN),
        words("which", "masks"),
        numbers("true"),
        numbers("recall", data=_rate_or_words),
        numbers("found", "detected"),
        numbers("precision", data=_rate_or_words),
        numbers("doubled"),
        numbers("precision_once", "precision less doubled", _rate_or_words),
        numbers("crops"),
        numbers("top1", "top-1", _rate_or_words),
        numbers("top5", "top-5", _rate_or_words),
        numbers("synonym_top1", "synonyms top-1", _rate_or_words),
        numbers("synonym_top5", "synonyms top-5", _rate_or_words),
    )
    caption = (
        f"Distinct tours, single views. Recall: true masks from {detector.min_mask_px} px (no walls, ceilings, floors) met at an "
        f"IoU of {LEAST_IOU}; precision: detected masks (confidence {detector.confidence}) that meet one. Doubled: met by a "
        "surer mask before. Top-1, top-5: the right category among those of the scene, by its noun or the mean over synonyms, "
        f"which may be {SYNONYMS_BELOW:.2f} below."
    )
    return Table(caption, columns, pd.DataFrame(shown, dtype=object), wide=True)


def _row(score: Score) -> dict[str, object]:
    section = _SECTIONS[score.group]
    row: dict[str, object] = {SECTION: section, "of": section, "which": _NAMES.get(score.group, score.value)}
    return row | {name: getattr(score, name) for name in (*_COUNTS, *RATES)}


def _whole(scores: Iterable[Score]) -> Score:
    for score in scores:
        if score.group == ALL:
            return score
    raise ValueError("perception: there is no row of all masks; make the file again")


def _value(score: Score, name: str, absent: float = math.nan) -> float:
    value: float | None = getattr(score, name)
    return absent if value is None else value


def _rate_or_words(value: float | str) -> str:
    return value if isinstance(value, str) else three(value)
