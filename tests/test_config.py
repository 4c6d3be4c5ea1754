"""Settings: a wrong one is named in one line with its remedy; partial settings name what they lack."""

from __future__ import annotations

import json
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from ovman.settings import Settings
from ovman.settings.config import ConfigError, load, load_files
from ovman.settings.settings_files import check_command_line, read_merged, with_parts
from ovman.settings.settings_files import read as read_file

FILE = Path(__file__).parents[1] / "config.yaml"
TREE = read_merged(with_parts(FILE))
CONFIG = load(FILE)
VALUES = CONFIG.constants()
RELATIONS = ("moved", "former", "moving", "stable", "appeared", "removed")

MINE = {"kind": "embodied", "system": "mine", "memory": "two visits", "agent": "ovman.agents.oracle:agent"}
STATIC = MINE | {"kind": "static", "agent": "ovman.agents.reference.agents:predict_two_visits"}
ONES = dict.fromkeys(RELATIONS, 1)
HOMES = {"seed": 1, "count": 2, "rooms": [1, 2], "assets": "train"}
SPLIT = {"episodes": ONES, "draws": ONES, "tries": 1, "arms": ["single_visit"]}
CROSSED = {"crossed": {"queries": [5, 8], "apart_m": 1.0}, "arms": ["single_visit"]}


def changed(values: Mapping[str, Any], below: Mapping[str, Any] = TREE) -> dict[str, Any]:
    """Return config.yaml, or another tree, with other values by dotted names; None takes a setting out."""
    tree: dict[str, Any] = json.loads(json.dumps(below))
    for name, value in values.items():
        *path, last = name.split(".")
        section = tree
        for key in path:
            section = section.setdefault(key, {})
        if value is None:
            del section[last]
        else:
            section[last] = deepcopy(value)
    return tree


def message(source: Any) -> str:
    with pytest.raises(ConfigError) as caught:
        load_files(source) if isinstance(source, list) else load(source)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 400
    return text


@settings(max_examples=8)
@given(st.randoms(use_true_random=False))
def test_key_order_and_number_form_and_the_users_own_sections_do_not_count(random):
    def shuffled(value: Any) -> Any:
        if isinstance(value, dict):
            keys = list(value)
            random.shuffle(keys)
            return {key: shuffled(value[key]) for key in keys}
        if type(value) in (int, float) and value == int(value):
            return random.choice([int, float])(value)
        return [shuffled(v) for v in value] if isinstance(value, list) else value

    tree = shuffled(TREE) | {"x-notes": {"anything": [1]}}
    # The order of the arms, the splits and the comparisons is that of the tables.
    tree |= {name: TREE[name] for name in ("comparisons", "paper")}
    tree |= {section: {name: tree[section][name] for name in TREE[section]} for section in ("arms", "splits")}
    assert load(tree) == CONFIG


def read(settings: Settings, name: str) -> Any:
    here: Any = settings
    for key in name.split("."):
        here = here[key] if isinstance(here, dict) else getattr(here, key)
    return here


@settings(max_examples=8)
@given(st.sets(st.sampled_from(sorted(VALUES)), max_size=12))
def test_partial_settings_hold_what_they_are_given_and_name_what_they_lack(names):
    given_constants = {name: VALUES[name] for name in VALUES if name in names and VALUES[name] is not None}
    for partial in (Settings.partial(given_constants), Settings.partial(changed(given_constants, {}))):
        assert partial.constants() == given_constants
        for name in VALUES:
            if name in given_constants:
                assert read(partial, name) == read(CONFIG, name)
            elif not name.startswith("splits."):
                with pytest.raises(AttributeError, match=f"this job was not given '{name}'; name it in the params of its rule"):
                    read(partial, name)


def test_partial_settings_are_frozen_and_change_only_what_they_hold():
    partial = Settings.partial({"camera.width_px": 300, "splits.main.scenes": ["FloorPlan1"]})
    assert partial.splits["main"].scenes == ("FloorPlan1",)
    with pytest.raises(AttributeError, match=r"this job was not given 'splits.main.arms'"):
        partial.splits["main"].arms  # noqa: B018
    with pytest.raises(ValidationError, match="frozen"):
        partial.camera.width_px = 3
    assert partial.with_values({"camera.width_px": 30}).camera.width_px == 30
    with pytest.raises(AttributeError, match=r"lack 'mover.step_m'"):
        partial.with_values({"mover.step_m": 1.0})
    with pytest.raises(AttributeError, match=r"'camera.width' is not a constant"):
        Settings.partial({"camera.width": 300})


WRONG = [
    ({"association.gama_m": 1.0}, "association.gama_m is not a setting; did you mean gate_m?"),
    ({"asociation.gate_m": 1.0}, "asociation is not a setting; did you mean association?"),
    ({"success.tau_m": 1.0}, "success.tau_m is not a setting; did you mean admissibility.tau_m?"),
    ({"success.xyzzy": 1.0}, "success.xyzzy is not a setting; success has radius_m, visible_px, sweep_deg"),
    ({"association.gate_m": -1}, "association.gate_m is -1; it must be above 0 (metres, gamma)"),
    ({"mover.pause_probability": 1.0}, "mover.pause_probability is 1.0; it must be below 1 "),
    ({"mover.step_m": float("nan")}, "mover.step_m is NaN; it must be a finite number "),
    ({"association.gate_m": "1.0"}, 'association.gate_m is "1.0"; it must be a number (metres, gamma); write numbers without'),
    ({"tour.waypoints": 2.5}, "tour.waypoints is 2.5; it must be an integer "),
    ({"tour.waypoints": True}, "tour.waypoints is true; it must be an integer "),
    ({"tour.waypoints": 10**9}, "tour.waypoints is 1000000000; it must be at most 1000 (W, "),
    ({"association.gate_m": None}, "association.gate_m (metres, gamma) is missing; add it"),
    ({"splits.main.draws": 3}, "splits.main.draws is 3; it must be a section "),
    ({"benchmark.backend": "unity"}, 'benchmark.backend is "unity"; it must be one of embedded, thor '),
    ({"evaluation.seeds": []}, "evaluation.seeds is []; it must be a list of at least 1 element"),
    ({"evaluation.seeds": [1, 1]}, "evaluation.seeds: 1 is there twice"),
    ({"sensitivity.tau_m": [0.5]}, "sensitivity: combinations is 256, but the lists make 128; change one of them"),
    ({"sensitivity.tau_m": [0.5, 0.5]}, "sensitivity.tau_m: 0.5 is there twice"),
    ({"sensitivity.tau_m": [0.5, 1.4]}, "sensitivity.tau_m has 1.4, but delta_min_m has 1.3"),
    ({"tolerances.tau_m": [0.4, 0.9]}, "tolerances.tau_m leaves the range of sensitivity.tau_m, 0.5 to 1.0; narrow it"),
    ({"sensitivity.min_mask_px": [10, 600]}, "sensitivity.min_mask_px is 10, but measurement.min_mask_px must be at most that"),
    ({"sensitivity.visible_px": [1, 600]}, "sensitivity.visible_px is 1, but measurement.visible_px must be at most that"),
    ({"sensitivity.validity_radius_m": [0.6, 9.0]}, "sensitivity.validity_radius_m is 9.0, but"),
    ({"gate_sweep.gates_m": [2.0, 1.0]}, "gate_sweep.gates_m: the gates do not rise"),
    # Values that make no sense together.
    ({"admissibility.min_mask_px": 20}, "admissibility.min_mask_px is 20, but measurement.min_mask_px must be at most that"),
    ({"primitives.turn_deg": 37}, "primitives.turn_deg is 37.0, which does not divide 360; write a divisor of "),
    ({"primitives.turn_deg": 45.0}, "primitives.heading_tolerance_deg is 15.0, which is less than half of primitives.turn_deg"),
    ({"dualmap.local_map.split_frames": 10}, "dualmap.local_map.split_frames is 10, but the 10 keyframes of "),
    ({"appearance.agent": "cow"}, "appearance.agent is cow, which is not a static arm that answers from maps"),
    # Splits.
    ({"splits.main": None}, "splits has no main; add it"),
    ({"splits.main.scenes": ["FloorPlan31"]}, "splits.main.scenes: FloorPlan31 is not a scene; there are "),
    ({"splits.main.scenes": ["FloorPlan1"] * 2}, "splits.main.scenes: FloorPlan1 is there twice"),
    ({"splits.main.episodes.moved": 10**6}, "splits.main.episodes.moved is 1000000, but splits.main.draws.moved x scenes are 4"),
    ({"splits.main.episodes": dict.fromkeys(RELATIONS, 0)}, "splits.main: a split without crossed needs episodes and draws"),
    ({"splits.a1": SPLIT}, "splits.a1.name: 'a1' cannot name a split; write small letters, with _ between words"),
    ({"splits.static": SPLIT}, "splits.static.name: 'static' cannot name a split; "),
    (
        {"splits.main.crossed": CROSSED["crossed"], "splits.main.episodes": None, "splits.main.draws": None},
        "splits.main.crossed is given, but main follows the paper; draw world pairs",
    ),
    ({"splits.own": CROSSED, "splits.own.crossed.queries": [8, 5]}, "splits.own.crossed: queries is [8, 5]; write the fewest"),
    ({"splits.own": CROSSED, "splits.own.crossed.queries": [5]}, "splits.own.crossed.queries is [5]; it must be a list of"),
    ({"splits.own": CROSSED, "splits.own.crossed.apart_m": None}, "splits.own.crossed.apart_m is missing; add it"),
    ({"splits.own": CROSSED | {"changes": [2]}}, "splits.own: a crossed split draws one world pair per scene; take"),
    ({"splits.own": CROSSED | SPLIT}, "splits.own: a crossed split draws one world pair per scene; take"),
    ({"splits.own": SPLIT | {"changes": [1, 2]}}, "splits.own: changes: one change and several are drawn in different ways;"),
    ({"splits.own": SPLIT | {"scenes": []}}, "splits.own: a split has either scenes or homes; write one of them"),
    ({"splits.own": SPLIT | {"homes": HOMES, "scenes": ["FloorPlan6"]}}, "splits.own: a split has either scenes or homes;"),
    ({"splits.own": SPLIT | {"homes": HOMES | {"rooms": [4]}}}, "splits.own.homes.rooms is 4; it must be one of 1, 2, 3"),
    ({"splits.own": SPLIT | {"homes": HOMES | {"assets": "all"}}}, "splits.own.homes.assets is \"all\"; it must be"),
    ({"splits.own": SPLIT | {"homes": HOMES | {"seed": -1}}}, "splits.own.homes.seed is -1; it must be"),
    ({"splits.own": SPLIT | {"in_main_job": False}}, "splits.own.in_main_job is false, but FloorPlan1 is a scene of the main"),
    (
        {f"splits.{name}": SPLIT | {"homes": HOMES, "in_main_job": name == "own"} for name in ("own", "again")},
        "splits.again.in_main_job is false, but Home-train-1-1.0 is a scene of the main",
    ),
    ({"splits.own": SPLIT | {"arms": ["cow", "dualmap_two_visits"]}}, "splits.own.arms.1 is dualmap_two_visits, whose records"),
    # Arms.
    ({"arms.Mine": MINE}, "arms.Mine.name: 'Mine' cannot name an arm, whose files are called after it; write small letters"),
    ({"arms.mine": MINE | {"name": "yours"}}, "arms: mine.name is not a setting; the key is the name"),
    ({"arms.mine": MINE | {"nedes": ["maps"]}}, "arms.mine.nedes is not a setting; did you mean needs?"),
    ({"arms.mine": {"kind": "static"}}, "is missing; add it, docs/agents.md shows an entry"),
    ({"arms.mine": MINE | {"agent": "oracle"}}, "arms.mine.agent: 'oracle' names no function; write \"package.module:function\""),
    ({"arms.mine": MINE | {"kind": "both"}}, 'arms.mine.kind is "both"; it must be one of static, embodied'),
    ({"arms.mine": MINE | {"needs": ["eyes"]}}, 'arms.mine.needs is "eyes"; it must be one of tours, maps, maintained, networks'),
    ({"arms.mine": MINE | {"runs": 3}}, "arms.mine.runs is not for an arm that is embodied; take it out"),
    ({"arms.mine": STATIC | {"budget": 9}}, "arms.mine.budget is not for an arm that is static; take it out"),
    ({"arms.mine": MINE | {"made_by": "x"}}, "arms.mine.made_by is x, which is not in section plugins; the plug-ins are none"),
    ({"arms.mine": MINE | {"constants": ["cow"]}}, "arms.mine.constants names cow, which is not a setting; write"),
    ({"arms.mine": MINE | {"executes": "oracle_check"}}, "arms.mine.executes is oracle_check, which is not a known static arm"),
    ({"arms.mine": MINE | {"withheld": "noun"}}, "arms.mine.withheld is not for an arm that is embodied; take it out"),
    ({"arms.mine": STATIC | {"withheld": "noun", "grounding": "handed"}}, "arms.mine.withheld is noun, but the arm is handed"),
    (
        {"arms.mine": STATIC | {"withheld": "first_visit", "needs": ["maintained"]}},
        "arms.mine.withheld is first_visit, but maintained is made of both visits; name an arm that needs maps or tours",
    ),
    ({"arms.mine": MINE | {"executes": "wrong_noun"}}, "arms.mine.executes is wrong_noun, from which noun_wrong is withheld,"),
    ({"arms.mine": MINE | {"cut_from": "oracle_check"}}, "arms.mine.cut_from is oracle_check, from whose runs it cannot be cut;"),
    ({"arms.mine": MINE | {"track": "speech"}}, 'arms.mine.track is "speech"; it must be one of paper, words'),
    ({"arms.mine": STATIC | {"track": "words", "positions": "handed"}}, "arms.mine.track is words, but the arm is handed what"),
    ({"arms.mine": MINE | {"track": "words", "executes": "joint"}}, "arms.mine.track is words, but that of joint, which the arm"),
    # Comparisons.
    ({"comparisons.agent": "cow"}, "comparisons.agent is cow, which is not a static arm; name one"),
    ({"comparisons.memory.arm": "cow"}, "comparisons.memory.arm is cow, which is not a static arm; name one"),
    ({"comparisons.memory.arm": "joint"}, "comparisons.memory.arm is joint; name an arm that needs maps at most, is handed"),
    ({"comparisons.difficulty.cow": "CoW"}, "comparisons.difficulty.cow is an embodied arm; name a static one"),
    ({"comparisons.rungs.single_visit": "one"}, "comparisons.rungs.single_visit follows positions_two_visits, but no entry of"),
    ({"comparisons.pairs.a": {"arm": "two_visits", "baseline": "cow"}}, "comparisons.pairs.a compares two_visits with cow, of"),
    ({"comparisons.pairs.a": {"arm": "single_visit", "baseline": "two_visits"}}, "comparisons.pairs.a tests single_visit, a"),
    ({"comparisons.pairings.a": {"arm": "two_visits_embodied", "baseline": "cow"}}, "comparisons.pairings.a has an embodied"),
    ({"comparisons.pairs.a": {"arm": "two_visits"}}, "comparisons.pairs.a.baseline (the arm that it is tested against) is"),
    ({"comparisons.overview.CoW.static": "cow"}, "comparisons.overview.CoW.static is cow, which is not an arm of kind static;"),
    ({"comparisons.controls.two_visits.role": "depth"}, "comparisons.controls.two_visits.role is depth, which is that of"),
    ({"comparisons.pears": {}}, "comparisons.pears is not a setting; did you mean pairs?"),
]  # fmt: skip


@pytest.mark.parametrize(("values", "expected"), WRONG)
def test_a_wrong_setting_is_one_line_with_file_key_and_remedy(values, expected):
    said = message(changed(values))
    assert said.startswith("config.yaml: ") and expected in said


def test_the_file_that_has_the_wrong_setting_is_named(tmp_path):
    overlay, base = tmp_path / "mine.yaml", tmp_path / "config.yaml"
    overlay.write_text("association: {gama_m: 1.0}\n")
    assert message([FILE, overlay]).startswith("mine.yaml: association.gama_m")
    overlay.write_text("association: {gate_m: 1.0}\n")
    base.write_text(yaml.safe_dump(changed({"association.gama_m": 1.0})))
    assert message([base, overlay]).startswith("config.yaml: association.gama_m")


LEVELS = range(1, 10)
ALIASES = "".join(["a0: &a0 {x: 1}\n", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in LEVELS)]).encode()
"""Nine levels of nine aliases each: 400 million values."""


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"camera:\n  width_px: 1\n  width_px: 2\n", ":2:3: width_px is there twice; write it once"),
        (b"camera: [1\n", ":2:1: did not find expected ',' or ']'; mend the YAML there"),
        (b"tour:\n\twaypoints: 3\n", ":2:1: found character that cannot start any token; indent with spaces"),
        (b"tour: {}\nmaps: {} # caf\xe9\n", ":2:15: is not UTF-8 text (byte 0xe9); save it as UTF-8"),
        (b"tour: {}\nmaps: {}\0\n", ":2:9: holds the character U+0000; remove it"),
        (b"a: 1\n---\nb: 2\n", ":2:1: but found another document; mend the YAML there"),
        (b"a: *b\n", ":1:4: found undefined alias; mend the YAML there"),
        (b"tour: &a {waypoints: *a}\n", ":1:7: an alias (*) stands inside what it names; write the values out"),
        (ALIASES, ":6:5: its aliases (*) make more than 100000 values; write the values out"),
        (b"- 1\n- 2\n", ": holds [1, 2]; it must hold sections (benchmark:, camera:, ...)"),
        (b"# nothing\n", ": is empty; it must hold sections (benchmark:, camera:, ...)"),
        (None, ": No such file or directory; give the path of a file of settings (.yaml)"),
    ],
)
def test_a_file_that_is_no_settings_is_one_line(tmp_path, content, expected):
    path = tmp_path / "wrong.yaml"
    if content is not None:
        path.write_bytes(content)
    assert message(path) == f"{path}{expected}"
    # And so it is on Snakemake's command line, before Snakemake reads it.
    for option in (["--configfile", str(FILE), str(path)], [f"--configfiles={path}", "-n"]):
        with pytest.raises(SystemExit) as ended:
            check_command_line(["--cores", "1", *option, "--", "results/tables"])
        assert ended.value.code == f"{path}{expected}"


def test_aliases_merge_keys_and_a_mark_of_the_byte_order_are_read(tmp_path):
    path = tmp_path / "settings.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: [*a, *a]\n")
    assert read_file(path) == {"a": {"x": 1, "y": 2}, "b": {"x": 1, "y": 3}, "c": [{"x": 1, "y": 2}] * 2}


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=5,
)


@given(st.sampled_from(sorted(VALUES)), junk.filter(lambda value: value is not None))
def test_whatever_is_written_somewhere_is_accepted_or_refused_in_one_line(name, value):
    try:
        load(changed({name: value}))
    except ConfigError as error:
        assert "\n" not in str(error) and name.split(".")[0] in str(error)


@given(junk)
def test_whatever_is_written_instead_of_everything_is_refused_in_one_line(value):
    message(value if isinstance(value, Mapping) else {"benchmark": value})
