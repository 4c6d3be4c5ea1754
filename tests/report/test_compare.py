"""What the comparison with the release says of constants, episodes and rows that were changed."""

from __future__ import annotations

import json
import shutil

from ovman.report.release import compare
from ovman.settings.config import load_files
from ovman.shipped import EMBEDDED, HOME

RELEASE = HOME / EMBEDDED
CONFIG = HOME / "config.yaml"


def test_the_release_is_as_released():
    constants, episodes, tables = compare(RELEASE, RELEASE, load_files([CONFIG]))
    assert constants == "constants: as released"
    assert "main 219 as released" in episodes and "of which" not in episodes
    assert "differ" not in tables


def test_each_difference_is_named(tmp_path):
    for folder in ("episodes", "tables"):
        shutil.copytree(RELEASE / folder, tmp_path / folder)
    first, *others = (tmp_path / "episodes" / "main.jsonl").read_text().splitlines(keepends=True)
    moved = json.loads(first) | {"noun": "another"}
    (tmp_path / "episodes" / "main.jsonl").write_text("".join([json.dumps(moved) + "\n", *others[1:]]))
    table = tmp_path / "tables" / "taxonomy.csv"
    table.write_text(table.read_text().replace("near miss", "far miss"))
    settings = load_files([CONFIG]).with_values({"evaluation.near_miss_m": 1.5})
    constants, episodes, tables = compare(tmp_path, RELEASE, settings)
    assert constants == "constants: evaluation.near_miss_m 2.0 -> 1.5"
    assert "main 218, of which 217 as released" in episodes
    assert "differ in taxonomy (1)" in tables
