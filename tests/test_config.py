"""A setting that is wrong is named in one line with its remedy; a stage sees what it owns, and its parameter tells that apart."""

from __future__ import annotations

import copy
import itertools
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from ovman.report.tables.constants import KEYS
from ovman.section import listed
from ovman.settings import Kind, Settings, arms_of, of_kind
from ovman.settings.config import ConfigError, load
from ovman.settings.settings import matching
from ovman.settings.settings_files import check_command_line, read, read_merged, with_parts
from ovman.workflow.parameter import StageSettings, canonical, own_constants, stage_settings
from ovman.workflow.stages import ENTRIES, STAGES, owned
from tests.arms import ARMS

FILE = Path(__file__).parents[1] / "config.yaml"
TREE = read_merged(with_parts(FILE))
CONFIG = load(FILE)
VALUES = CONFIG.constants()


def changed(config: Settings, values: Mapping[str, Any]) -> Settings:
    """`config` with other values, unchecked: what is compared here need not make sense together."""
    for name, value in values.items():
        config = _changed(config, name.split("."), value)
    return config


def _changed(section: Any, path: list[str], value: Any) -> Any:
    inner = value if len(path) == 1 else _changed(getattr(section, path[0]), path[1:], value)
    return section.model_copy(update={path[0]: inner})


OF_ARMS = {"predictions": Kind.STATIC, "rollouts": Kind.EMBODIED}
Job = tuple[str, str | None]
JOBS: tuple[Job, ...] = (
    *((stage, None) for stage in STAGES if stage not in OF_ARMS),
    *((stage, arm.name) for stage, kind in OF_ARMS.items() for arm in of_kind(ARMS, kind)),
)
"""Stages, and the jobs of a stage that is divided among the arms."""


def patterns(job: Job) -> tuple[str, ...]:
    """What a job owns: what its stage does, and what its arm, or one whose answer that executes, says that it reads."""
    stage, arm = job
    involved = [] if arm is None else [arm, *filter(None, [CONFIG.arms[arm].executes])]
    return STAGES[stage] + tuple(pattern for name in involved for pattern in own_constants(CONFIG.arms[name]))


def owners(*names: str) -> set[Job]:
    return {job for job in JOBS if matching(patterns(job), names)}


BEFORE = {job: canonical(CONFIG, *job) for job in JOBS}


def affected(config: Settings) -> set[Job]:
    return {job for job in JOBS if canonical(config, *job) != BEFORE[job]}


def pairs() -> Iterator[tuple[str, str]]:
    """Every constant with another of its type that has another value, the next one in the file; no mapping has another's form."""
    names = [name for name, value in VALUES.items() if not isinstance(value, list)]
    for k, a in enumerate(names):
        others = (b for b in names[k + 1 :] + names[:k] if type(VALUES[a]) is type(VALUES[b]) and VALUES[a] != VALUES[b])
        yield from ((a, b) for b in itertools.islice(others, 1))


def with_value(name: str, value: Any, tree: Mapping[str, Any] = TREE) -> dict[str, Any]:
    tree = copy.deepcopy(dict(tree))
    *path, last = name.split(".")
    section = tree
    for key in path:
        section = section.setdefault(key, {})
    if value is None:
        del section[last]
    else:
        section[last] = value
    return tree


def message(source: Any, **kwargs: Any) -> str:
    with pytest.raises(ConfigError) as caught:
        load(source, **kwargs)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 250
    return text


def test_every_constant_has_an_owner_but_for_those_that_no_result_follows_from():
    """Seeds say which files there are, scenes of a job which job makes a file, limits of agents when one is given up."""
    of_no_stage = {name for name in VALUES if not owners(name)}
    of_jobs = {"evaluation.seeds", "evaluation.scenes_per_job"}
    assert of_no_stage == of_jobs | {name for name in VALUES if name.startswith("remote.")}


def test_what_stages_says_exists():
    for stage, patterns in STAGES.items():
        for pattern in patterns:
            assert any(n == pattern or (pattern.endswith(".*") and n.startswith(pattern[:-1])) for n in VALUES), (stage, pattern)


def test_the_tables_own_what_they_show():
    memory = {"comparisons.memory.arm", "comparisons.memory.baseline"}
    shown = memory | {
        *KEYS,
        "arms",
        "splits",
        "comparisons.agent",
        "comparisons.rungs",
        "comparisons.difficulty",
        "comparisons.shortcuts",
        "comparisons.controls",
        "evaluation.confidence",
        "evaluation.near_miss_m",
    }
    assert set(owned("tables", list(VALUES))) == shown


def test_a_constant_with_the_value_of_another_changes_the_parameter_of_its_owners_only():
    tried = 0
    for a, b in pairs():
        assert affected(changed(CONFIG, {a: VALUES[b]})) == owners(a), (a, b)
        tried += 1
    assert tried > 80


@pytest.mark.soak
def test_two_constants_that_swap_their_values_change_the_parameters_of_both_owners():
    for a, b in pairs():
        assert affected(changed(CONFIG, {a: VALUES[b], b: VALUES[a]})) == owners(a, b), (a, b)


def test_the_order_of_a_mapping_counts():
    mappings = [name for name, value in VALUES.items() if isinstance(value, list) and name not in ("arms", "splits")]
    names = ("rungs", "pairs", "pairings", "readings", "difficulty", "shortcuts", "overview", "controls")
    assert mappings == [f"comparisons.{name}" for name in names] + ["paper.static", "paper.embodied"]
    for name in mappings:
        section, last = name.split(".")
        value = getattr(getattr(CONFIG, section), last)
        assert affected(changed(CONFIG, {name: dict(reversed(value.items()))})) == owners(name), name


def test_sequences_count():
    assert affected(changed(CONFIG, {"success.sweep_deg": (0, 60)})) == owners("success.sweep_deg")
    assert affected(changed(CONFIG, {"benchmark.backend": "thor"})) == owners("benchmark.backend")


@settings(derandomize=True, max_examples=25, deadline=None)
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
    # The order of the arms, the splits and of what is compared is that of the tables.
    tree |= {name: TREE[name] for name in ("comparisons", "paper")}
    tree |= {section: {name: tree[section][name] for name in TREE[section]} for section in ("arms", "splits")}
    assert affected(load(tree)) == set()


def test_a_stage_sees_what_it_owns_and_is_told_what_it_does_not():
    for job in JOBS:
        stage, view = job[0], stage_settings(CONFIG, *job)
        mine = matching(patterns(job), VALUES)
        for name in VALUES:
            *sections, last = name.split(".")
            if name in mine:
                here: Any = view
                for section in sections:
                    here = getattr(here, section)
                if name == "arms":
                    assert arms_of(here.arms) == ARMS
                else:
                    seen, there = listed(getattr(here, last)), VALUES[name]
                    if fields := ENTRIES.get(stage, {}).get(name):
                        seen, there = ([{key: one[key] for key in fields} for one in entries] for entries in (seen, there))
                    assert seen == there
            else:
                with pytest.raises(AttributeError, match=stage):
                    here = view
                    for section in sections:
                        here = getattr(here, section)
                    getattr(here, last)


def test_who_answers_a_split_reaches_no_stage_that_draws_it():
    everyday = CONFIG.splits["everyday"]
    fewer = everyday.model_copy(update={"arms": everyday.arms[:-1]})
    touched = {stage for stage, _ in affected(changed(CONFIG, {"splits": {**CONFIG.splits, "everyday": fewer}}))}
    assert touched and not touched & {"candidates", "episodes"}
    more = everyday.model_copy(update={"episodes": everyday.episodes.model_copy(update={"moved": 1})})
    touched = {stage for stage, _ in affected(changed(CONFIG, {"splits": {**CONFIG.splits, "everyday": more}}))}
    assert "episodes" in touched and "candidates" not in touched
    redrawn = everyday.model_copy(update={"light": None})
    touched = {stage for stage, _ in affected(changed(CONFIG, {"splits": {**CONFIG.splits, "everyday": redrawn}}))}
    assert {"candidates", "episodes"} <= touched
    view = stage_settings(CONFIG, "candidates").splits["everyday"]
    assert (view.others, view.light, dict(view.draws)) == (everyday.others, everyday.light, dict(everyday.draws)) and view.single
    with pytest.raises(AttributeError, match="'candidates' does not own the constant 'splits.everyday.arms'"):
        view.arms  # noqa: B018


def test_a_view_is_made_of_the_very_parameter_and_frozen():
    text = canonical(CONFIG, "trials")
    view = StageSettings.parse(text)
    assert view.canonical == text and view.stage == "trials"
    assert view.benchmark.seed == CONFIG.benchmark.seed
    assert view.success.sweep_deg == (0, 30, 60)
    for target in (view, view.camera):
        with pytest.raises(ValidationError, match="frozen"):
            target.width_px = 3
    assert copy.copy(json.loads(text))["constants"]["camera.width_px"] == 300


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("association.gama_m", 1.0, "config.yaml: association.gama_m is not a setting; did you mean gate_m?"),
        ("asociation.gate_m", 1.0, "config.yaml: asociation is not a setting; did you mean association?"),
        ("success.tau_m", 1.0, "config.yaml: success.tau_m is not a setting; did you mean admissibility.tau_m?"),
        ("success.xyzzy", 1.0, "config.yaml: success.xyzzy is not a setting; success has radius_m, visible_px, sweep_deg"),
        ("association.gate_m", -1, "config.yaml: association.gate_m is -1; it must be greater than 0 (metres, gamma)"),
        ("mover.pause_probability", 1.0, "config.yaml: mover.pause_probability is 1.0; it must be less than 1 "),
        ("mover.step_m", float("nan"), "config.yaml: mover.step_m is nan; it must be a finite number "),
        (
            "association.gate_m",
            "1.0",
            'config.yaml: association.gate_m is "1.0"; it must be a valid number (metres, gamma); write',
        ),
        ("tour.waypoints", 2.5, "config.yaml: tour.waypoints is 2.5; it must be a valid integer "),
        ("tour.waypoints", True, "config.yaml: tour.waypoints is true; it must be a valid integer "),
        ("association.gate_m", None, "config.yaml: association.gate_m (metres, gamma) is missing; add it"),
        ("splits.main.draws", 3, "config.yaml: splits.main.draws is 3; it must be a section "),
        ("benchmark.backend", "unity", "config.yaml: benchmark.backend is \"unity\"; it must be 'embedded' or 'thor' "),
        ("splits.main.scenes", ["FloorPlan31"], "config.yaml: splits.main.scenes: FloorPlan31 is not a floor plan; there are "),
        ("splits.main.scenes", ["FloorPlan1"] * 2, "config.yaml: splits.main.scenes: FloorPlan1 is there twice"),
        ("evaluation.seeds", [], "config.yaml: evaluation.seeds is []; it must have at least 1 item"),
        (
            "admissibility.min_mask_px",
            20,
            "config.yaml: admissibility.min_mask_px is 20, but measurement.min_mask_px must be",
        ),
    ],
)
def test_a_wrong_setting_is_one_line_with_its_remedy(name, value, expected):
    assert message(with_value(name, value)).startswith(expected)


def test_the_file_that_has_the_wrong_setting_is_named(tmp_path):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("association: {gama_m: 1.0}\n")
    merged = with_value("association.gama_m", 1.0)
    assert message(merged, files=[FILE, overlay]).startswith("mine.yaml: association.gama_m")
    overlay.write_text("association: {gate_m: 1.0}\n")
    base = tmp_path / "config.yaml"
    base.write_text(yaml.safe_dump(with_value("association.gama_m", 1.0)))
    assert message(merged, files=[base, overlay]).startswith("config.yaml: association.gama_m")


LEVELS = range(1, 10)
ALIASES = "".join(["a0: &a0 {x: 1}\n", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in LEVELS)]).encode()
MERGED = "".join(["a0: &a0 {x: 1}\n", *(f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 9)}]}}\n" for n in LEVELS)]).encode()
"""Nine levels of nine aliases each: 400 million values."""


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"camera:\n  width_px: 1\n  width_px: 2\n", ":2:3: width_px is there twice; write it once"),
        (b'{"camera": {"width_px": 1, "width_px": 2}}', ":1:12: width_px is there twice; write it once"),
        (b"camera: [1\n", ":2:1: expected ',' or ']', but got '<stream end>'; mend the YAML there"),
        (b"camera: {a: 1}}\n", ":1:15: expected <block end>, but found '}'; mend the YAML there"),
        (b"tour:\n\twaypoints: 3\n", r":2:1: found character '\t' that cannot start any token; indent with spaces"),
        (b"tour: {}\nmaps: {} # caf\xe9\n", ":2:15: is not UTF-8 text (byte 0xe9); save it as UTF-8"),
        ("tour: {}\n".encode("utf-16"), ":1:1: is UTF-16 text; save it as UTF-8"),
        ("tour: {}\n".encode("utf-16-le"), ":1:2: holds the character U+0000; remove it"),
        (b"tour: {}\nmaps: {}\0\n", ":2:9: holds the character U+0000; remove it"),
        (b"a: 1\n---\nb: 2\n", ":2:1: but found another document; mend the YAML there"),
        (b"a: *b\n", ":1:4: found undefined alias 'b'; mend the YAML there"),
        (b"tour: &a {waypoints: *a}\n", ":1:7: an alias (*) stands inside what it names; write the values out"),
        (ALIASES, ":6:5: its aliases (*) make more than 100000 values; write the values out"),
        (MERGED, ":6:14: its aliases (*) make more than 100000 values; write the values out"),
        (b"- 1\n- 2\n", ": holds [1, 2]; it must hold sections (benchmark:, camera:, ...)"),
        (b"camera\n", ': holds "camera"; it must hold sections (benchmark:, camera:, ...)'),
        (b"", ": is empty; it must hold sections (benchmark:, camera:, ...), or be left out"),
        (b"# nothing\n", ": is empty; it must hold sections (benchmark:, camera:, ...), or be left out"),
    ],
)
def test_a_file_that_is_no_settings_is_one_line(tmp_path, content, expected):
    path = tmp_path / "wrong.yaml"
    path.write_bytes(content)
    assert message(path) == f"{path}{expected}"
    # And so it is on Snakemake's command line, before Snakemake reads it.
    with pytest.raises(SystemExit) as ended:
        check_command_line(["--cores", "1", "--configfile", str(FILE), str(path), "--", "results/tables"])
    assert ended.value.code == f"{path}{expected}"


@pytest.mark.parametrize("option", [["--configfile", "{}"], ["--configfiles={}"], ["--configfile={}", "-n"]])
def test_every_form_of_the_option_is_looked_at_and_no_other(tmp_path, option):
    check_command_line(["--cores", "1", *(part.format(FILE) for part in option), "--configfile", str(FILE)])
    check_command_line(["--snakefile", str(tmp_path / "absent"), "--config", "a=1", "results/tables"])
    check_command_line(["--configfile"])
    with pytest.raises(SystemExit, match="absent.yaml: No such file or directory; give the path"):
        check_command_line([*(part.format(tmp_path / "absent.yaml") for part in option)])


def test_a_mark_of_the_byte_order_and_json_with_tabs_are_read_as_snakemake_reads_them(tmp_path):
    path = tmp_path / "marked.yaml"
    path.write_bytes(b"\xef\xbb\xbftour: {waypoints: 3}\n")
    assert read(path) == {"tour": {"waypoints": 3}}
    path.write_bytes(b'{\n\t"tour": {"waypoints": 3}\n}\n')
    assert read(path) == {"tour": {"waypoints": 3}}


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"tour.waypoints": 10**9}, "config.yaml: tour.waypoints is 1000000000; it must be less than or equal to 1000 (W, "),
        (
            {"splits.main.episodes.moved": 10**6},
            "config.yaml: splits.main.episodes.moved is 1000000, but splits.main.draws.moved x scenes are 4 x 20 = 80; lower ",
        ),
        (
            {"splits.main.draws.moved": 1},
            "config.yaml: splits.main.episodes.moved is 33, but splits.main.draws.moved x scenes are ",
        ),
        (
            {f"splits.main.episodes.{name}": 0 for name in ("moved", "former", "moving", "stable", "appeared", "removed")},
            "config.yaml: splits.main.episodes asks for no episode; give at least one relation a number above 0",
        ),
        ({"primitives.turn_deg": 37}, "config.yaml: primitives.turn_deg is 37.0, which does not divide 360; write a divisor of "),
        (
            {"primitives.turn_deg": 45.0},
            "config.yaml: primitives.heading_tolerance_deg is 15.0, which is less than half of primitives.turn_deg (45.0): some ",
        ),
        ({"dualmap.local_map.split_frames": 10}, "config.yaml: dualmap.local_map.split_frames is 10, but the 10 keyframes of "),
    ],
)
def test_values_that_make_no_sense_together_are_one_line_with_its_remedy(values, expected):
    tree = TREE
    for name, value in values.items():
        tree = with_value(name, value, tree)
    assert message(tree).startswith(expected)


def test_a_file_that_is_not_there_is_one_line(tmp_path):
    assert "absent.yaml: No such file" in message(tmp_path / "absent.yaml")


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=5,
)


@given(st.sampled_from(sorted(VALUES)), junk)
def test_whatever_is_written_somewhere_is_accepted_or_refused_in_one_line(name, value):
    tree = with_value(name, 0)
    *path, last = name.split(".")
    section = tree
    for key in path:
        section = section[key]
    section[last] = value
    try:
        load(tree)
    except ConfigError as error:
        assert "\n" not in str(error) and name.split(".")[0] in str(error)


@given(junk)
def test_whatever_is_written_instead_of_everything_is_refused_in_one_line(value):
    with pytest.raises(ConfigError) as caught:
        load(value if isinstance(value, Mapping) else {"benchmark": value})
    assert "\n" not in str(caught.value)


def test_aliases_and_merge_keys_are_read(tmp_path):
    path = tmp_path / "settings.yaml"
    path.write_text("a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: [*a, *a]\n")
    assert read(path) == {"a": {"x": 1, "y": 2}, "b": {"x": 1, "y": 3}, "c": [{"x": 1, "y": 2}] * 2}
