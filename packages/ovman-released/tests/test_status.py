"""A system that is not there: its arms, its record, and the note in the place of its rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from ovman.analysis import metrics
from ovman.models.settings import Kind, arms_of
from ovman.report import tables
from ovman.report.latex import latex
from ovman.report.markdown import markdown
from ovman.report.table import Column, Row, Table
from ovman.workflow.config import load
from ovman_released.status import Status, forget_failures, note, read

ROOT = Path(__file__).parents[3]
TREE = yaml.safe_load((ROOT / "config.yaml").read_text())
RELEASED = {name: entry["released"] for name, entry in TREE["arms"].items() if "released" in entry}


def with_root(system: str) -> dict:
    here = TREE["released"][system] | {"root": "somewhere"}
    return TREE | {"released": TREE["released"] | {system: here}}


def test_both_systems_have_arms_and_the_default_names_no_clone():
    assert "cow" in set(RELEASED.values()) and all(TREE["released"][system]["root"] == "" for system in RELEASED.values())
    assert not set(RELEASED) & set(load(TREE).arms)


@pytest.mark.parametrize("system", sorted(set(RELEASED.values())))
def test_a_clone_that_is_named_brings_its_arms_and_no_others(system):
    there = load(with_root(system)).arms
    assert set(there) - set(load(TREE).arms) == {name for name, of in RELEASED.items() if of == system}
    assert [name for name in TREE["arms"] if name in there] == list(there)


def test_a_record_says_what_it_was_given(tmp_path):
    for status in (Status("S", "a is missing; run: b"), Status("S")):
        status.write(tmp_path / "s.json")
        assert read(tmp_path / "s.json") == status
    assert note(tmp_path / "s.json") is None
    (tmp_path / "s.json").write_text("{}")
    with pytest.raises(ValueError, match="s.json"):
        read(tmp_path / "s.json")


def test_what_was_missing_is_older_than_whatever_it_was_made_of_and_what_was_run_is_not(tmp_path):
    """Snakemake then looks for it again."""
    Status("A", "missing").write(tmp_path / "a.json")
    Status("B").write(tmp_path / "b.json")
    (tmp_path / "input").write_text("")
    forget_failures(tmp_path)
    missing, run, made_of = ((tmp_path / name).stat().st_mtime for name in ("a.json", "b.json", "input"))
    assert missing < run <= made_of and read(tmp_path / "a.json") == Status("A", "missing")
    forget_failures(tmp_path / "nowhere")


def test_the_table_of_its_kind_has_a_note_and_no_other_has(tmp_path):
    Status("CoW (released)", "there is no clone in 50 % of a_place; run: x").write(tmp_path / "cow.json")
    arms = arms_of(load(with_root("cow")).arms)
    made = {name: Table(name, "Caption.", (Column("a", "a"),), (Row({"a": "1"}),)) for name in ("embodied", "static", "scenes")}
    after = {name: tables.noted(one, [tmp_path / "cow.json"], arms) for name, one in made.items()}
    assert after["static"] == made["static"] and after["scenes"] == made["scenes"]
    for written in (markdown(after["embodied"]), latex(after["embodied"])):
        assert "Caption. CoW (released) was not run" in " ".join(written.split())
        assert "a_place" not in written
    Status("CoW (released)").write(tmp_path / "cow.json")
    assert tables.noted(made["embodied"], [tmp_path / "cow.json"], arms) == made["embodied"]


def test_only_a_released_arm_may_be_without_records():
    cow = arms_of(load(with_root("cow")).arms)[0].model_copy(update={"name": "cow_released", "kind": Kind.EMBODIED})
    assert metrics._may_lack([cow]) == set()
    assert metrics._may_lack([replace(cow, released="cow")]) == {"cow_released"}
