"""What section `splits` refuses, each in one line, and what follows from an entry."""

from __future__ import annotations

from pathlib import Path

import pytest

from ovman.analysis.registry import paper_tables, split_tables
from ovman.report.tables.benchmark import describe_split
from ovman.settings import MAIN
from ovman.settings.config import ConfigError, load
from ovman.settings.settings_files import read_merged, with_parts
from training.floorplans import floor_plans

ROOT = Path(__file__).parents[1]
TREE = read_merged(with_parts(ROOT / "config.yaml"))
CONFIG = load(TREE)
COUNTS = dict.fromkeys(("moved", "former", "moving", "stable", "appeared", "removed"), 1)
ALIKE = COUNTS | {"moved": 2}
OTHERS = {"count": [3, 5], "alike": ALIKE, "size_ratio": 8.0}
ENTRY = {"episodes": COUNTS, "draws": COUNTS, "tries": 1, "arms": ["single_visit"]}


def with_entry(name: str = "own", **entry) -> dict:
    return TREE | {"splits": TREE["splits"] | {name: ENTRY | entry}}


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ({"others": OTHERS | {"count": [5, 3]}}, r"splits.own.others: count is \[5, 3\]; write the fewest before the most"),
        ({"others": OTHERS | {"count": [1, 3]}}, "alike.moved is 2, but count begins with 1; raise that or lower alike"),
        ({"others": OTHERS | {"count": [3]}}, r"splits.own.others.count is \[3\]; it must be a list of at least 2 element"),
        ({"others": OTHERS | {"size_ratio": 0.5}}, "splits.own.others.size_ratio is 0.5; it must be at least 1"),
        ({"others": OTHERS, "changes": [2]}, r"others change beside one scripted change, but changes is \[2\]; write \[1\]"),
        ({"changes": [1, 2]}, r"splits.own.changes: one change and several are drawn in different ways; write \[1\]"),
        ({"scenes": []}, r"splits.own.scenes is \[\]; it must be a list of at least 1 element"),
        ({"scenes": ["FloorPlan31"]}, "splits.own.scenes: FloorPlan31 is not a floor plan"),
        ({"scenes": ["FloorPlan6", "FloorPlan6"]}, "splits.own.scenes: FloorPlan6 is there twice"),
        ({"second_tour": {"other_waypoints": True, "first_yaw_deg": 360.0}}, "first_yaw_deg is 360.0; it must be below 360"),
        ({"in_main_job": False}, "splits.own.in_main_job is false, but FloorPlan1 is a scene of the main job; name other scenes"),
        ({"scenes": ["FloorPlan6"], "episodes": COUNTS | {"moved": 2}}, r"draws.moved x scenes are 1 x 1 = 1; lower it or draw"),
        ({"arms": ["cow", "dualmap_two_visits"]}, "is dualmap_two_visits, whose records are made of split main alone"),
    ],
)
def test_a_split_that_makes_no_sense_is_refused_in_one_line(entry, expected):
    with pytest.raises(ConfigError, match=expected) as refused:
        load(with_entry(**entry))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["static", "embodied", "Own", "two__words", "a1"])
def test_a_name_that_files_cannot_bear_is_refused(name):
    with pytest.raises(ConfigError, match="cannot name a split; write small letters, with _ between words"):
        load(with_entry(name))


def test_each_setting_of_a_split_can_be_switched_on_alone():
    turned = {"other_waypoints": False, "first_yaw_deg": 20.0}
    for entry, says in (
        ({}, "the paper's protocol"),
        ({"others": OTHERS}, "3 to 5 instances of other categories change as well"),
        ({"second_tour": turned}, "the second tour has views of its own"),
    ):
        split = load(with_entry(**entry)).splits["own"]
        assert describe_split(split) == says and split.single and split.plain == (entry == {})


def test_a_split_that_is_no_part_of_the_main_job_has_its_own_scenes_and_no_table_there():
    own = load(with_entry(in_main_job=False, scenes=["FloorPlan6"], arms=["single_visit", "oracle_check"]))
    assert own.splits["own"].scenes == ("FloorPlan6",)
    assert not [name for name in paper_tables(own) if name.startswith("own/")]
    assert split_tables(own, "own") == ["own/static_rates", "own/embodied_rates", "own/rejections"]
    assert split_tables(load(with_entry()), "own") == ["own/static_rates", "own/rejections"]


def test_what_is_chosen_on_is_neither_of_the_benchmark_nor_learned_from():
    taught = {*floor_plans(CONFIG.splits[MAIN].scenes).taught}
    apart = [split for split in CONFIG.splits.values() if not split.in_main_job]
    assert len(apart) >= 2
    for split in apart:
        assert split.scenes is not None and len(split.scenes) >= 8
        assert not {*split.scenes} & ({*CONFIG.splits[MAIN].scenes} | taught)
        assert sum(count for _, count in split.episodes) >= 60


def test_a_split_without_scenes_has_those_of_main_and_all_arms_answer_main():
    split = load(with_entry(scenes=None)).splits["own"]
    assert split.scenes == CONFIG.splits[MAIN].scenes and CONFIG.splits[MAIN].arms == tuple(CONFIG.arms)
    assert CONFIG.splits[MAIN].stream == () and CONFIG.splits["multi"].stream == ("multi",)
