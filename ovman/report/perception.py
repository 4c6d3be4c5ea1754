"""The tables of perception: what is found and named in the recorded tours, and where back-projected masks lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.analysis.scores import ALL, CATEGORIES, CATEGORY, SCENE, SIZE
from ovman.perception.overlap import LEAST_IOU
from ovman.report.cells import Record, grouped
from ovman.report.table import CSV_AND_MARKDOWN, Column, Row, Table

RATES = ("recall", "precision", "precision_once", "top1", "top5", "synonym_top1", "synonym_top5")
_SECTIONS = {ALL: "all scenes", CATEGORIES: "all scenes", SIZE: "by size of the mask", SCENE: "by scene"}
_NAMES = {ALL: "all", CATEGORIES: "mean over categories"}


@dataclass(frozen=True, slots=True)
class Bar:
    """What a rate of all scenes should reach."""

    rate: str
    least: float
    reached: float

    @property
    def met(self) -> bool:
        return self.reached >= self.least

    @property
    def verdict(self) -> str:
        return "met" if self.met else "not met"


LEAST = {"recall": 0.75, "precision": 0.75, "precision_once": 0.75, "top1": 0.60, "top5": 0.88}
SYNONYMS_BELOW = 0.10
"""Synonyms may be worse than the own nouns of the same categories by this much."""


def bars(rows: Sequence[Record]) -> dict[str, Bar]:
    """The bars by the name of their rate. rows: of "perception.csv". A rate that is empty, for want of masks, reaches nothing.

    Raises ValueError if there is no row of all.
    """
    whole = _whole(rows)
    least = {**LEAST, **{f"synonym_{top}": _value(whole[f"own_{top}"]) - SYNONYMS_BELOW for top in ("top1", "top5")}}
    return {rate: Bar(rate, least[rate], _value(whole[rate], -np.inf)) for rate in RATES}


def perception_table(rows: Sequence[Record], confidence: float, min_mask_px: int) -> Table:
    """All scenes with the bars, then by size and by scene. rows: of "perception.csv"; confidence and min_mask_px: the detector's.

    Raises ValueError if there is no row of all.
    """
    checked = bars(rows)
    table = [_row(_whole(rows)), *map(_row, (row for row in rows if row["group"] == CATEGORIES)), _chance(_whole(rows))]
    for name, cells in (
        ("bar", {rate: f"≥ {bar.least:.3f}" for rate, bar in checked.items()}),
        ("verdict", {rate: bar.verdict for rate, bar in checked.items()}),
    ):
        table.append(Row({"of": _SECTIONS[ALL], "which": name, **cells}, section=_SECTIONS[ALL]))
    table += [_row(row) for group in (SIZE, SCENE) for row in rows if row["group"] == group]
    return Table(
        name="perception",
        caption=(
            f"Perception against the true instances of the recorded tours, each distinct tour once. Recall: true masks of at "
            f"least {min_mask_px} px in single views that a detected one meets at an IoU of {LEAST_IOU}; precision: detected "
            f"masks at confidence {confidence} that meet a true one; walls, ceilings and floors are no instances. Doubled: "
            f"masks that meet an instance which a surer mask meets, too; precision counts them as right, and less doubled as "
            f"wrong. Top-1 and top-5: the right category among all of the scene, for the crops of the masks that meet an "
            f"instance, by the category's own noun and by the mean over its synonyms, which may be {SYNONYMS_BELOW:.2f} below "
            f"the own nouns of the same crops."
        ),
        columns=(
            Column("of", "of", formats=CSV_AND_MARKDOWN),
            Column("which", "masks"),
            Column("true", "true", numeric=True),
            Column("recall", "recall", numeric=True),
            Column("found", "detected", numeric=True),
            Column("precision", "precision", numeric=True),
            Column("doubled", "doubled", numeric=True),
            Column("precision_once", "precision less doubled", numeric=True),
            Column("crops", "crops", numeric=True),
            Column("top1", "top-1", numeric=True),
            Column("top5", "top-5", numeric=True),
            Column("synonym_top1", "synonyms top-1", numeric=True),
            Column("synonym_top5", "synonyms top-5", numeric=True),
        ),
        rows=tuple(table),
        wide=True,
    )


def backprojection_table(rows: Sequence[Record], min_mask_px: int) -> Table:
    """Both estimates over true and detected masks, and over objects by their worst mask. rows: of "backprojection.csv".

    Kinds of masks are in the order of the rows.
    """
    table = []
    for kind in dict.fromkeys(row["mask"] for row in rows):
        of_kind = [row for row in rows if row["mask"] == kind]
        objects = grouped(of_kind, "scene", "object")
        for key, name in (("median", "component-wise median"), ("ray", "single ray at median depth")):
            columns = (f"{key}_box_m", f"{key}_centre_m")
            of_masks = [[float(row[column]) for column in columns] for row in of_kind]
            of_objects = [[max(float(row[column]) for row in group) for column in columns] for group in objects.values()]
            for unit, errors in (("masks", of_masks), ("objects", of_objects)):
                if errors:
                    table.append(Row({"mask": kind, "estimate": name, "unit": unit, "n": str(len(errors)), **_summary(errors)}))
    return Table(
        name="backprojection",
        caption=(
            f"Self-check of the back-projection on the untouched tours: distance in metres from the estimate to the object's "
            f"axis-aligned box (0 inside) and, on the floor plane, to the box's centre, which no visible surface need be near. "
            f"True masks of at least {min_mask_px} px; detected ones that meet a true instance at an IoU of {LEAST_IOU}. Objects "
            f"count by their worst mask."
        ),
        columns=(
            Column("mask", "masks"),
            Column("estimate", "estimate"),
            Column("unit", "of"),
            Column("n", "n", numeric=True),
            *(
                Column(f"{column}_{key}", f"{column}, {title}", numeric=True)
                for column in ("box", "centre")
                for key, title in (("median", "median"), ("p95", "95th percentile"), ("max", "greatest"))
            ),
        ),
        rows=tuple(table),
        wide=True,
    )


def _summary(errors: Sequence[Sequence[float]]) -> dict[str, str]:
    """Cells of distances (N, 2) to the box and to its centre."""
    cells = {}
    for column, values in zip(("box", "centre"), np.array(errors).T, strict=True):
        statistics = {"median": np.median(values), "p95": np.percentile(values, 95), "max": values.max()}
        cells |= {f"{column}_{name}": f"{value:.4f}" for name, value in statistics.items()}
    return cells


def by_category(rows: Sequence[Record]) -> list[Record]:
    """The rows of single categories, those with the most true masks first."""
    return sorted((row for row in rows if row["group"] == CATEGORY), key=lambda row: (-int(row["true"]), row["value"]))


def _whole(rows: Sequence[Record]) -> Record:
    for row in rows:
        if row["group"] == ALL:
            return row
    raise ValueError("perception: there is no row of all masks; make the file again")


def _row(row: Record) -> Row:
    cells = {"of": _SECTIONS[row["group"]], "which": _NAMES.get(row["group"], row["value"])}
    cells |= {key: row[key] for key in ("true", "found", "doubled", "crops") if row[key]}
    cells |= {rate: f"{float(row[rate]):.3f}" for rate in RATES if row[rate]}
    return Row(cells, section=_SECTIONS[row["group"]])


def _chance(whole: Record) -> Row:
    cells = {top: f"{float(whole[f'chance_{top}']):.3f}" for top in ("top1", "top5") if whole[f"chance_{top}"]}
    return Row({"of": _SECTIONS[ALL], "which": "chance", **cells}, section=_SECTIONS[ALL])


def _value(text: str, absent: float = np.nan) -> float:
    return float(text) if text else absent
