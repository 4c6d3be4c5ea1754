"""Settings: a wrong one is named in one line with its remedy; partial settings name what they lack."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from ovman.settings import Settings, schema
from ovman.settings.config import ConfigError, load
from ovman.settings.settings_files import check_command_line, read_merged, with_parts
from ovman.settings.settings_files import read as read_file

FILE = Path(__file__).parents[1] / "config.yaml"
TREE = read_merged(with_parts(FILE))
CONFIG = load(FILE)
VALUES = CONFIG.constants()


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
    # The order of the arms, the splits and the comparisons is that of the tables.
    tree |= {name: TREE[name] for name in ("comparisons", "paper")}
    tree |= {section: {name: tree[section][name] for name in TREE[section]} for section in ("arms", "splits")}
    assert load(tree) == CONFIG


def read(settings: Settings, name: str) -> Any:
    here: Any = settings
    for key in name.split("."):
        here = here[key] if isinstance(here, dict) else getattr(here, key)
    return here


@settings(max_examples=20, deadline=None)
@given(st.sets(st.sampled_from(sorted(VALUES)), max_size=12))
def test_partial_settings_hold_what_they_are_given_and_name_what_they_lack(names):
    given_constants = {name: VALUES[name] for name in VALUES if name in names}
    tree: dict[str, Any] = {}
    for name, value in json.loads(json.dumps(given_constants)).items():
        *sections, last = name.split(".")
        here = tree
        for section in sections:
            here = here.setdefault(section, {})
        here[last] = value
    for partial in (Settings.partial(given_constants), Settings.partial(tree)):
        assert partial.constants() == given_constants
        for name in VALUES:
            if name in names:
                assert read(partial, name) == read(CONFIG, name)
            elif not name.startswith("splits."):
                with pytest.raises(AttributeError, match=f"this job was not given '{name}'; name it in the params of its rule"):
                    read(partial, name)


def test_partial_settings_are_frozen_and_change_only_what_they_hold():
    partial = Settings.partial({"camera.width_px": 300, "splits.main.scenes": ["FloorPlan1"]})
    assert partial.splits["main"].scenes == ("FloorPlan1",)
    with pytest.raises(AttributeError, match="this job was not given 'splits.main.arms'"):
        partial.splits["main"].arms  # noqa: B018
    with pytest.raises(ValidationError, match="frozen"):
        partial.camera.width_px = 3
    assert partial.with_values({"camera.width_px": 30}).camera.width_px == 30
    with pytest.raises(AttributeError, match="lack 'mover.step_m'"):
        partial.with_values({"mover.step_m": 1.0})
    with pytest.raises(AttributeError, match="'camera.width' is not a constant"):
        Settings.partial({"camera.width": 300})


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("association.gama_m", 1.0, "config.yaml: association.gama_m is not a setting; did you mean gate_m?"),
        ("asociation.gate_m", 1.0, "config.yaml: asociation is not a setting; did you mean association?"),
        ("success.tau_m", 1.0, "config.yaml: success.tau_m is not a setting; did you mean admissibility.tau_m?"),
        ("success.xyzzy", 1.0, "config.yaml: success.xyzzy is not a setting; success has radius_m, visible_px, sweep_deg"),
        ("association.gate_m", -1, "config.yaml: association.gate_m is -1; it must be above 0 (metres, gamma)"),
        ("mover.pause_probability", 1.0, "config.yaml: mover.pause_probability is 1.0; it must be below 1 "),
        ("mover.step_m", float("nan"), "config.yaml: mover.step_m is NaN; it must be a finite number "),
        (
            "association.gate_m",
            "1.0",
            'config.yaml: association.gate_m is "1.0"; it must be a number (metres, gamma); write',
        ),
        ("tour.waypoints", 2.5, "config.yaml: tour.waypoints is 2.5; it must be an integer "),
        ("tour.waypoints", True, "config.yaml: tour.waypoints is true; it must be an integer "),
        ("association.gate_m", None, "config.yaml: association.gate_m (metres, gamma) is missing; add it"),
        ("splits.main.draws", 3, "config.yaml: splits.main.draws is 3; it must be a section "),
        ("benchmark.backend", "unity", 'config.yaml: benchmark.backend is "unity"; it must be one of embedded, thor '),
        ("splits.main.scenes", ["FloorPlan31"], "config.yaml: splits.main.scenes: FloorPlan31 is not a floor plan; there are "),
        ("splits.main.scenes", ["FloorPlan1"] * 2, "config.yaml: splits.main.scenes: FloorPlan1 is there twice"),
        ("evaluation.seeds", [], "config.yaml: evaluation.seeds is []; it must be a list of at least 1 element"),
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
    assert read_file(path) == {"tour": {"waypoints": 3}}
    path.write_bytes(b'{\n\t"tour": {"waypoints": 3}\n}\n')
    assert read_file(path) == {"tour": {"waypoints": 3}}


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"tour.waypoints": 10**9}, "config.yaml: tour.waypoints is 1000000000; it must be at most 1000 (W, "),
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
    assert read_file(path) == {"a": {"x": 1, "y": 2}, "b": {"x": 1, "y": 3}, "c": [{"x": 1, "y": 2}] * 2}


def test_the_schema_for_editors_is_that_of_the_models_and_accepts_each_file():
    text = schema.FILE.read_text()
    assert text == schema.schema_text(), "the models have changed: python -m ovman.settings.schema"
    for file in with_parts(FILE):
        jsonschema.validate(read_file(file) | {"x-notes": [1]}, json.loads(text))
    for name, value in (("tour.waypoints", 0), ("tour.way", 3), ("success.radius_m", "1")):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(with_value(name, value), json.loads(text))
