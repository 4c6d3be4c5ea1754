"""The section `arms` of config.yaml as a table, and what of an entry a job depends on."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest
import yaml

from ovman.evaluation.supervision import load_agent
from ovman.settings import Kind, Source, arms_of, named, of_kind
from ovman.settings.arms import other_readings
from ovman.settings.config import ConfigError, load
from ovman.settings.jobs import arm_job, job_of_arm, settings_of_arm
from ovman.settings.settings_files import read_merged, with_parts
from tests.arms import ARMS, CONFIG, ROOT

TREE = read_merged(with_parts(ROOT / "config.yaml"))
NAMES = list(TREE["arms"])
MINE = {"kind": "embodied", "system": "mine", "memory": "two visits", "agent": "ovman.agents.oracle:agent"}
STATIC = MINE | {"kind": "static", "agent": "ovman.agents.reference.agents:predict_two_visits"}


def loaded(**entries: Any):
    return load(TREE | {"arms": TREE["arms"] | entries})


def test_rows_of_a_table_are_told_apart_by_what_the_table_shows():
    elsewhere = other_readings(ARMS)
    shown = [arm for arm in of_kind(ARMS, Kind.STATIC) if arm.name not in elsewhere]
    static = [(arm.system, arm.memory, arm.grounding, arm.positions) for arm in shown]
    embodied = [arm.system for arm in of_kind(ARMS, Kind.EMBODIED)]
    assert len(set(static)) == len(static)
    assert len(set(embodied)) == len(embodied)


def test_an_embodied_arm_executes_the_static_arm_that_is_like_it():
    followed = [(arm, named(ARMS, arm.executes)) for arm in ARMS if arm.executes is not None]
    assert len(followed) == 7
    for arm, static in followed:
        assert (static.memory, static.grounding, static.positions) == (arm.memory, arm.grounding, arm.positions)


def test_positions_handed_over_leave_nothing_to_ground_and_the_answer_is_handed_to_the_oracle_alone():
    assert all(arm.grounding is Source.HANDED for arm in ARMS if arm.positions is Source.HANDED)
    assert [arm.name for arm in ARMS if arm.answer is Source.HANDED] == ["oracle_check"]


def test_kinds_partition_the_arms_which_keep_the_order_of_the_file():
    assert sorted(arm.name for kind in Kind for arm in of_kind(ARMS, kind)) == sorted(arm.name for arm in ARMS)
    assert [arm.name for arm in ARMS] == NAMES
    turned = dict(reversed(TREE["arms"].items()))
    assert [arm.name for arm in arms_of(load(TREE | {"arms": turned}).arms)] == NAMES[::-1]


def test_the_function_of_every_arm_is_there():
    assert all(callable(load_agent(arm.name, arm.agent)) for arm in ARMS)


def test_an_unknown_arm_is_answered_with_the_known_ones():
    with pytest.raises(KeyError, match="oracle_check"):
        named(ARMS, "oracle")


def test_an_overlay_adds_arms_and_leaves_them_out():
    arms = loaded(mine=MINE, oracle_check=None).arms
    assert list(arms) == [name for name in NAMES if name != "oracle_check"] + ["mine"]


def test_merged_arms_stand_in_the_order_of_the_files_however_they_were_merged(tmp_path):
    (tmp_path / "overlay.yaml").write_text(yaml.safe_dump({"arms": {"mine": MINE, "cow": {"system": "changed"}}}))
    arms = TREE["arms"] | {"mine": MINE, "cow": TREE["arms"]["cow"] | {"system": "changed"}}
    files = [ROOT / "config.yaml", tmp_path / "overlay.yaml"]
    read = load(TREE | {"arms": {name: arms[name] for name in ("mine", "cow", *arms)}}, files).arms
    assert list(read) == [*NAMES, "mine"] and read["cow"].system == "changed"


@pytest.mark.parametrize(
    ("entry", "line"),
    [
        ({"Mine": MINE}, "arms: 'Mine' cannot name an arm, whose files are called after it; write small letters, digits and _"),
        ({"mine": MINE | {"nedes": ["maps"]}}, "arms.mine.nedes is not a setting; did you mean needs?"),
        ({"mine": {k: v for k, v in MINE.items() if k != "agent"}}, "docs/agents.md shows an entry"),
        ({"mine": MINE | {"agent": "oracle"}}, "arms.mine.agent: 'oracle' names no function; write \"package.module:function\""),
        ({"mine": MINE | {"kind": "both"}}, "arms.mine.kind is \"both\"; it must be one of static, embodied"),
        (
            {"mine": MINE | {"needs": ["eyes"]}},
            "arms.mine.needs is \"eyes\"; it must be one of tours, maps, maintained, networks, dualmap, ",
        ),
        ({"mine": MINE | {"runs": 3}}, "arms.mine.runs is not for an arm that is embodied; take it out"),
        ({"mine": MINE | {"kind": "static", "budget": 9}}, "arms.mine.budget is not for an arm that is static; take it out"),
        ({"mine": MINE | {"constants": ["cow"]}}, "arms.mine.constants names cow, which is not a setting; write"),
        ({"mine": MINE | {"executes": "oracle_check"}}, "arms.mine.executes is oracle_check, which is not a known static arm"),
        ({"mine": MINE | {"withheld": "noun"}}, "arms.mine.withheld is not for an arm that is embodied; take it out"),
        ({"mine": STATIC | {"withheld": "verb"}}, "arms.mine.withheld is \"verb\"; it must be one of noun, noun_wrong,"),
        ({"mine": STATIC | {"withheld": "noun", "grounding": "handed"}}, "arms.mine.withheld is noun, but the arm is handed"),
        (
            {"mine": STATIC | {"withheld": "first_visit", "needs": ["maintained"]}},
            "arms.mine.withheld is first_visit, but maintained is made of both visits; name an arm that needs maps or tours",
        ),
        (
            {"mine": MINE | {"executes": "wrong_noun"}},
            "arms.mine.executes is wrong_noun, from which noun_wrong is withheld, and from an embodied arm nothing is;",
        ),
        ({"mine": MINE | {"cut_from": "oracle_check"}}, "arms.mine.cut_from is oracle_check, from whose runs it cannot be cut;"),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_one_line_with_file_key_and_remedy(entry, line):
    with pytest.raises(ConfigError) as caught:
        loaded(**entry)
    said = str(caught.value)
    assert said.startswith("config.yaml: arms") and line in said and "\n" not in said


def test_a_job_of_an_arm_has_its_entry_without_the_words_of_the_tables():
    def jobs(config):
        return {name: job_of_arm(config, name) for name in config.arms if name != "mine"}

    before = jobs(CONFIG)
    assert jobs(loaded(mine=MINE)) == before
    two = TREE["arms"]["two_visits"]
    assert jobs(loaded(two_visits=two | {"system": "another", "memory": "words", "control": True})) == before
    changed = jobs(loaded(two_visits=two | {"constants": [*two["constants"], "maps.cluster_radius_m"]}))
    assert {name for name in before if changed[name] != before[name]} == {"two_visits", "two_visits_embodied"}


def test_a_job_of_an_arm_is_given_the_constants_that_its_entry_names_and_an_arm_that_is_cut_from_it_leaves_a_mark():
    mine = MINE | {"constants": ["maps.*", "tour.waypoints"], "needs": ["networks"], "budget": 500}
    config = loaded(mine=mine, short=MINE | {"cut_from": "mine", "budget": 250})
    assert arm_job(config, "mine").marks == (250,) and arm_job(config, "mine").budget == 500
    constants = settings_of_arm(config, "mine").constants()
    assert {"maps.cluster_radius_m", "tour.waypoints", "perception.device"} <= set(constants)
    assert not {"tour.headings", "grounding.similarity_margin"} & set(constants)


def test_the_table_is_read_without_anything_heavy():
    heavy = "numpy", "scipy", "pandas", "torch"
    script = f"import sys, ovman.settings; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
