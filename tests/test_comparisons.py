"""Sections `comparisons` and `paper` of the settings: what does not fit the arms is refused in one line."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from ovman.analysis.metrics import write_metrics
from ovman.settings import arms_of
from ovman.settings.config import ConfigError, load
from ovman.settings.settings_files import read_merged, with_parts
from tests.arms import CONFIG
from tests.episodes import DATA

ROOT = Path(__file__).parents[1]


def overlay(**sections):
    tree = read_merged(with_parts(ROOT / "config.yaml"))
    for name, entries in sections.items():
        for key, value in entries.items():
            old = tree[name].get(key)
            tree[name][key] = {**old, **value} if isinstance(old, dict) and isinstance(value, dict) else value
    return tree


MINE = {"kind": "static", "system": "mine", "memory": "two visits", "agent": "my_agents.mine:predict"}


def test_an_arm_of_a_user_has_its_significance_test(tmp_path):
    """An overlay with an arm and a pair gives rows in significance.csv."""
    tree = overlay(
        arms={"mine": MINE}, comparisons={"pairs": {"mine against two visits": {"arm": "mine", "baseline": "two_visits"}}}
    )
    settings = load(tree)
    theirs = DATA / "predictions" / "main" / "two_visits.jsonl"
    mine = tmp_path / "mine.jsonl"
    mine.write_text(theirs.read_text(encoding="utf-8").replace('"arm":"two_visits"', '"arm":"mine"'), encoding="utf-8")
    write_metrics(DATA / "episodes" / "main.jsonl", [theirs, mine], [], settings, tmp_path)
    with (tmp_path / "significance.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["arm"] == "mine"]
    assert [row["relation"] for row in rows] == ["moved", "former", "moving", "stable", "appeared", "removed", "all"]
    assert {row["title"] for row in rows} == {"mine against two visits"} and rows[-1]["p"] == "1"


def test_entries_keep_the_order_of_the_files_and_null_leaves_one_out():
    title = "mine against two visits"
    tree = overlay(
        arms={"mine": MINE},
        comparisons={"pairs": {title: {"arm": "mine", "baseline": "two_visits"}, "two visits against one": None}},
    )
    read = load(tree)
    assert [*read.comparisons.pairs] == [*[*CONFIG.comparisons.pairs][1:], title]
    again = read
    assert again.comparisons.pairs == read.comparisons.pairs and [*again.comparisons.pairs] == [*read.comparisons.pairs]
    assert again.comparisons.rungs == read.comparisons.rungs and [*again.comparisons.rungs] == [*read.comparisons.rungs]
    assert arms_of(again.arms) == arms_of(read.arms)


@pytest.mark.parametrize(
    ("comparisons", "said"),
    [
        ({"agent": "cow"}, "comparisons.agent is cow, which is not a static arm; there are single_visit,"),
        ({"difficulty": {"cow": "CoW"}}, "comparisons.difficulty.cow is an embodied arm; name a static one"),
        (
            {"rungs": {"single_visit": "one"}},
            "comparisons.rungs.single_visit follows positions_two_visits, but no entry of comparisons.pairs tests single_visit",
        ),
        (
            {"pairs": {"a": {"arm": "two_visits", "baseline": "cow"}}},
            "pairs.a compares two_visits with cow, of which one is",
        ),
        ({"pairs": {"a": {"arm": "single_visit", "baseline": "two_visits"}}}, "a tests single_visit, a stochastic pick;"),
        ({"pairings": {"a": {"arm": "two_visits_embodied", "baseline": "cow"}}}, "comparisons.pairings.a has an embodied arm;"),
        ({"pairs": {"a": {"arm": "two_visits"}}}, "comparisons.pairs.a.baseline (the arm that it is tested against) is missing"),
        (
            {"overview": {"CoW": {"static": "cow"}}},
            "comparisons.overview.CoW.static is cow, which is not an arm of kind static; name one",
        ),
        (
            {"controls": {"two_visits": {"role": "depth"}}},
            "comparisons.controls.two_visits.role is depth, which is that of another entry, too; rename one",
        ),
        ({"controls": {"two_visits": {"rule": ""}}}, "comparisons.controls.two_visits.rule is not a setting; did you mean role?"),
        ({"pears": {}}, "comparisons.pears is not a setting; did you mean pairs?"),
    ],
)
def test_a_comparison_that_makes_no_sense_is_one_line(comparisons, said):
    with pytest.raises(ConfigError) as caught:
        load(overlay(comparisons=comparisons))
    assert said in str(caught.value) and "\n" not in str(caught.value)
