"""Sections `arms`, `splits` and `comparisons` of config.yaml: what follows from an entry, and what of an arm a job depends on."""

from __future__ import annotations

import yaml

from ovman.analysis.registry import paper_tables, split_tables
from ovman.evaluation.supervision import load_agent
from ovman.settings import MAIN, Kind, Source, of_kind
from ovman.settings.arms import other_readings
from ovman.settings.config import load, load_files
from ovman.settings.settings import arm_job, job_of_arm, settings_of_arm
from tests.arms import ARMS, BY_NAME, CONFIG, ROOT
from tests.test_config import MINE, SPLIT, STATIC, TREE, changed
from training.floorplans import floor_plans

NAMES = list(TREE["arms"])


def with_arms(**entries):
    return load(TREE | {"arms": TREE["arms"] | entries})


def with_split(**entry):
    return load(changed({"splits.own": SPLIT | entry}))


def test_rows_of_a_table_are_told_apart_by_what_the_table_shows():
    elsewhere = other_readings(ARMS)
    shown = [arm for arm in of_kind(ARMS, Kind.STATIC) if arm.name not in elsewhere]
    static = [(arm.system, arm.memory, arm.grounding, arm.positions) for arm in shown]
    embodied = [arm.system for arm in of_kind(ARMS, Kind.EMBODIED)]
    assert len(set(static)) == len(static)
    assert len(set(embodied)) == len(embodied)


def test_an_embodied_arm_executes_the_static_arm_that_is_like_it():
    followed = [(arm, BY_NAME[arm.executes]) for arm in ARMS if arm.executes is not None]
    assert followed
    for arm, static in followed:
        assert (static.memory, static.grounding, static.positions) == (arm.memory, arm.grounding, arm.positions)


def test_positions_handed_over_leave_nothing_to_ground_and_the_answer_is_handed_to_the_oracle_alone():
    # Two rungs of the joint agent are given one part of the truth and ground themselves.
    rungs = ("joint_true_identity", "joint_true_boxes")
    handed = [arm for arm in ARMS if arm.positions is Source.HANDED and arm.name not in rungs]
    assert all(arm.grounding is Source.HANDED for arm in handed)
    assert [arm.name for arm in ARMS if arm.answer is Source.HANDED] == ["oracle_check"]


def test_the_function_of_every_arm_is_there():
    assert all(callable(load_agent(arm.name, arm.agent)) for arm in ARMS)


def test_entries_keep_the_order_of_the_files_and_null_leaves_one_out(tmp_path):
    overlay = {"arms": {"mine": STATIC, "cow": {"system": "changed"}, "oracle_check": None}}
    pairs = {"mine against two visits": {"arm": "mine", "baseline": "two_visits"}, "two visits against one": None}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(overlay | {"comparisons": {"pairs": pairs}}))
    settings = load_files([ROOT / "config.yaml", tmp_path / "mine.yaml"])
    assert list(settings.arms) == [name for name in NAMES if name != "oracle_check"] + ["mine"]
    assert settings.arms["cow"].system == "changed"
    kept = [title for title in CONFIG.comparisons.pairs if title != "two visits against one"]
    assert [*settings.comparisons.pairs] == [*kept, "mine against two visits"]
    assert [arm.name for arm in load(TREE | {"arms": dict(reversed(TREE["arms"].items()))}).arms.values()] == NAMES[::-1]


def test_a_job_of_an_arm_has_its_entry_without_the_words_of_the_tables():
    def jobs(config):
        return {name: job_of_arm(config, name) for name in config.arms if name != "mine"}

    before = jobs(CONFIG)
    assert jobs(with_arms(mine=MINE)) == before
    two = TREE["arms"]["two_visits"]
    assert jobs(with_arms(two_visits=two | {"system": "another", "memory": "words", "control": True})) == before
    other = jobs(with_arms(two_visits=two | {"constants": [*two["constants"], "maps.cluster_radius_m"]}))
    assert {name for name in before if other[name] != before[name]} == {"two_visits", "two_visits_embodied"}


def test_a_job_of_an_arm_is_given_the_constants_that_its_entry_names_and_an_arm_that_is_cut_from_it_leaves_a_mark():
    mine = MINE | {"constants": ["maps.*", "tour.waypoints"], "needs": ["networks"], "budget": 500}
    config = with_arms(mine=mine, short=MINE | {"cut_from": "mine", "budget": 250})
    assert arm_job(config, "mine").marks == (250,) and arm_job(config, "mine").budget == 500
    constants = settings_of_arm(config, "mine").constants()
    assert {"maps.cluster_radius_m", "tour.waypoints", "perception.device"} <= set(constants)
    assert not {"tour.headings", "grounding.similarity_margin"} & set(constants)


def test_a_split_that_is_no_part_of_the_main_job_has_its_own_scenes_and_no_table_there():
    own = with_split(in_main_job=False, scenes=["FloorPlan6"], arms=["single_visit", "oracle_check"])
    assert own.splits["own"].scenes == ("FloorPlan6",)
    assert not [name for name in paper_tables(own) if name.startswith("own/")]
    assert split_tables(own, "own") == ["own/static_rates", "own/embodied_rates", "own/rejections"]
    assert split_tables(with_split(), "own") == ["own/static_rates", "own/rejections"]


def test_scenes_to_tune_on_are_neither_of_the_benchmark_nor_learned_from():
    taught = {*floor_plans(CONFIG.splits[MAIN].scenes).taught}
    apart = [split for split in CONFIG.splits.values() if not split.in_main_job]
    assert len(apart) >= 2
    for split in apart:
        if split.homes is not None:
            assert split.homes.count >= 8 and split.homes.assets == "val"
            continue
        assert len(split.scenes) >= 8 and not {*split.scenes} & ({*CONFIG.splits[MAIN].scenes} | taught)
        assert sum(count for _, count in split.episodes) >= 60
    assert {split.homes.assets for split in CONFIG.splits.values() if split.homes and split.in_main_job} == {"test"}


def test_a_split_without_scenes_has_those_of_main_and_arms_answer_main_that_do_not_say_otherwise():
    split = with_split().splits["own"]
    assert split.scenes == CONFIG.splits[MAIN].scenes
    assert CONFIG.splits[MAIN].arms == tuple(name for name, arm in CONFIG.arms.items() if arm.on_main)
    assert CONFIG.splits[MAIN].stream == () and CONFIG.splits["multi"].stream == ("multi",)
