"""The table of where back-projected masks lie."""

from __future__ import annotations

import pandas as pd

from ovman.perception.overlap import LEAST_IOU
from ovman.report.tables.columns import numbers, words
from ovman.report.tables.table import Table
from ovman.settings import Settings

ESTIMATES = {"median": "component-wise median", "ray": "single ray at median depth"}
STATISTICS = {"median": "median", "p95": "95th percentile", "max": "greatest"}


def backprojection_table(masks: pd.DataFrame, settings: Settings) -> Table:
    """Both estimates over true and detected masks, and over objects by their worst mask. masks: rows of `Localised`.

    Kinds of masks are in the order of the rows.
    """
    rows = []
    for kind, of_kind in masks.groupby("mask", sort=False):
        for key, name in ESTIMATES.items():
            errors = of_kind.rename(columns={f"{key}_box_m": "box", f"{key}_centre_m": "centre"})
            of_objects = errors.groupby(["scene", "object"], sort=False)[["box", "centre"]].max()
            for unit, of_unit in (("masks", errors[["box", "centre"]]), ("objects", of_objects)):
                row: dict[str, object] = {"mask": kind, "estimate": name, "unit": unit, "n": len(of_unit)}
                for column in ("box", "centre"):
                    values = of_unit[column]
                    found = {"median": values.median(), "p95": values.quantile(0.95), "max": values.max()}
                    row |= {f"{column}_{statistic}": value for statistic, value in found.items()}
                rows.append(row)
    columns = (
        words("mask", "masks"),
        words("estimate"),
        words("unit", "of"),
        numbers("n"),
        *(
            numbers(f"{column}_{key}", f"{column}, {title}", four)
            for column in ("box", "centre")
            for key, title in STATISTICS.items()
        ),
    )
    caption = (
        f"Self-check of the back-projection on the untouched tours: distance in metres from the estimate to the object's "
        f"axis-aligned box (0 inside) and, on the floor plane, to the box's centre, which no visible surface need be near. "
        f"True masks of at least {settings.perception.detector.min_mask_px} px; detected ones that meet a true instance at "
        f"an IoU of {LEAST_IOU}. Objects count by their worst mask."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def four(value: float) -> str:
    """Four decimals: 0.1 mm."""
    return f"{value:.4f}"
