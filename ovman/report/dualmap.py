"""The table of how many objects DualMap's maps hold."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ovman.analysis.rates import ALL
from ovman.report.cells import Record, grouped
from ovman.report.table import Column, Row, Table


def dualmap_table(objects: Sequence[Record]) -> Table:
    """One row a scene and kind of map, over all runs. objects: rows of "dualmap.csv"."""
    groups = grouped(objects, "memory", "scene")
    return Table(
        name="dualmap",
        caption=(
            "DualMap's maps: how many keyframes they were made of, and how many objects they hold at the end, the mean over maps "
            "and runs, the least and the most of a map. Two visits: maps of single visits; maintained map: one map through two "
            "visits."
        ),
        columns=(
            Column("memory", "memory"),
            Column("scene", "scene"),
            Column("runs", "runs", numeric=True),
            Column("maps", "maps", numeric=True),
            Column("frames", "keyframes", numeric=True),
            Column("objects", "objects", numeric=True),
            Column("objects_min", "least", numeric=True),
            Column("objects_max", "most", numeric=True),
        ),
        rows=tuple(_row(memory, scene, rows, objects) for (memory, scene), rows in groups.items()),
    )


def _row(memory: str, scene: str, rows: Sequence[Record], objects: Sequence[Record]) -> Row:
    maps = [int(row["maps"]) for row in rows]

    def mean(key: str) -> str:
        """Over all maps."""
        return f"{math.fsum(float(row[key]) * n for row, n in zip(rows, maps, strict=True)) / sum(maps):.1f}"

    runs = {row["run"] for row in (objects if scene == ALL else rows)} - {ALL}
    return Row(
        {
            "memory": memory,
            "scene": scene,
            "runs": str(len(runs)),
            "maps": str(sum(maps)),
            "frames": mean("frames"),
            "objects": mean("objects_mean"),
            "objects_min": str(min(int(row["objects_min"]) for row in rows)),
            "objects_max": str(max(int(row["objects_max"]) for row in rows)),
        }
    )
