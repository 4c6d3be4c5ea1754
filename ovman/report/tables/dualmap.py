"""The table of how many objects DualMap's maps hold."""

from __future__ import annotations

import math

import pandas as pd

from ovman.report.tables.columns import ALL, numbers, words
from ovman.report.tables.table import Table
from ovman.settings import Settings


def dualmap_table(objects: pd.DataFrame, settings: Settings) -> Table:
    """One row a kind of map and scene, over all runs. objects: rows of `Objects`. Means weigh every map alike."""
    every = objects["run"][objects["run"] != ALL].nunique()
    rows = [
        {
            "memory": memory,
            "scene": scene,
            "runs": every if scene == ALL else len(group),
            "maps": group["maps"].sum(),
            "frames": _mean(group["frames"], group["maps"]),
            "objects": _mean(group["objects_mean"], group["maps"]),
            "objects_min": group["objects_min"].min(),
            "objects_max": group["objects_max"].max(),
        }
        for (memory, scene), group in objects.groupby(["memory", "scene"], sort=False)
    ]
    columns = (
        words("memory"),
        words("scene"),
        numbers("runs"),
        numbers("maps"),
        numbers("frames", "keyframes", one_decimal),
        numbers("objects", data=one_decimal),
        numbers("objects_min", "least"),
        numbers("objects_max", "most"),
    )
    caption = (
        "DualMap's maps: how many keyframes they were made of, and how many objects they hold at the end, the mean over maps "
        "and runs, the least and the most of a map. Two visits: maps of single visits; maintained map: one map through two "
        "visits."
    )
    return Table(caption, columns, pd.DataFrame(rows))


def one_decimal(value: float) -> str:
    """One decimal."""
    return f"{value:.1f}"


def _mean(values: pd.Series[float], weights: pd.Series[int]) -> float:
    return math.fsum(values * weights) / weights.sum()
