"""Section `comparisons` of the settings: a pair is tested."""

from __future__ import annotations

import csv

from ovman.analysis.metrics import write_metrics
from ovman.settings.config import load
from tests.episodes import DATA
from tests.test_config import STATIC, changed


def test_an_arm_of_a_user_has_its_significance_test(tmp_path):
    """An overlay with an arm and a pair gives rows in significance.csv."""
    pair = {"arm": "mine", "baseline": "two_visits"}
    settings = load(changed({"arms.mine": STATIC, "comparisons.pairs.mine against two visits": pair}))
    theirs = DATA / "predictions" / "main" / "two_visits.jsonl"
    mine = tmp_path / "mine.jsonl"
    mine.write_text(theirs.read_text(encoding="utf-8").replace('"arm":"two_visits"', '"arm":"mine"'), encoding="utf-8")
    write_metrics(DATA / "episodes" / "main.jsonl", [theirs, mine], [], settings, tmp_path)
    with (tmp_path / "significance.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["arm"] == "mine"]
    assert [row["relation"] for row in rows] == ["moved", "former", "moving", "stable", "appeared", "removed", "all"]
    assert {row["title"] for row in rows} == {"mine against two visits"} and rows[-1]["p"] == "1"
