"""How many objects DualMap's maps hold is counted by scene, reading and run."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ovman.agents.dualmap.mapped import Entry, Mapped, RunMaps, Sort, write
from ovman.analysis import dualmap_objects


def mapped(objects: int, frames: int) -> Mapped:
    return Mapped(tuple(Entry(np.zeros(2), np.eye(3)[0], Sort.OBJECT, 0, 8, 0, 9) for _ in range(objects)), frames)


def test_a_row_for_all_and_one_for_each_run_of_each_scene(tmp_path: Path, capsys):
    one = [RunMaps({"a": mapped(n, 10), "b": mapped(n + 2, 20)}, {("a", "b"): mapped(n + 5, 30)}) for n in (3, 5)]
    write(tmp_path / "FloorPlan1.npz", one)
    write(tmp_path / "FloorPlan2.npz", [RunMaps({"a": mapped(40, 50)}, {})])
    write(tmp_path / "FloorPlan3.npz", [RunMaps({}, {})])
    dualmap_objects.run([tmp_path / f"FloorPlan{n}.npz" for n in (1, 2, 3)], tmp_path / "dualmap.csv")
    rows = list(csv.DictReader((tmp_path / "dualmap.csv").open()))
    found = {(row.pop("scene"), row.pop("memory"), row.pop("run")): [float(v) for v in row.values()] for row in rows}
    assert found == {
        ("all", "two visits", "all"): [5, 22, 12, 3, 40],
        ("all", "maintained map", "all"): [2, 30, 9, 8, 10],
        ("FloorPlan1", "two visits", "0"): [2, 15, 4, 3, 5],
        ("FloorPlan1", "maintained map", "0"): [1, 30, 8, 8, 8],
        ("FloorPlan1", "two visits", "1"): [2, 15, 6, 5, 7],
        ("FloorPlan1", "maintained map", "1"): [1, 30, 10, 10, 10],
        ("FloorPlan2", "two visits", "0"): [1, 50, 40, 40, 40],
    }
    assert capsys.readouterr().out.splitlines() == [
        "two visits: 5 maps of 3 to 40 objects, 12.0 on average",
        "maintained map: 2 maps of 8 to 10 objects, 9.0 on average",
    ]
