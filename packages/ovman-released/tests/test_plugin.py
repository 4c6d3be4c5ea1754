"""The plug-ins: what their overlays register, what a wrong setting says, and the note in the place of missing rows."""

from __future__ import annotations

import subprocess
import sys

import pytest
import yaml
from settings_of import PACKAGE, ROOT, settings_of

from ovman.records.note import Note
from ovman.report.tables import add_notes
from ovman.report.tables.table import Column, Group, Table, latex, markdown
from ovman.settings import Kind, Settings
from ovman.settings.config import ConfigError, load_files
from ovman_released.plugin import COW, DUALMAP
from ovman_released.settings import released_cow, released_dualmap

SYSTEMS = {"cow": COW, "dualmap": DUALMAP}


def test_without_the_overlays_there_are_no_arms_of_released_systems_and_no_sections():
    plain = settings_of()
    assert type(plain) is Settings and plain.plugins == {}
    assert not [arm.name for arm in plain.arms.values() if arm.made_by or "released" in arm.name]


@pytest.mark.parametrize("system", SYSTEMS)
def test_an_overlay_brings_its_section_and_its_arms_and_no_others(system):
    plain, there = settings_of(), settings_of(system)
    name = SYSTEMS[system]
    assert set(type(there).model_fields) - set(type(plain).model_fields) == {name}
    new = [arm for arm in there.arms.values() if arm.name not in plain.arms]
    assert new and {arm.made_by for arm in new} == {name}
    assert list(there.arms)[: len(plain.arms)] == list(plain.arms)
    names = {arm.name for arm in new}
    compared = {pair for one in (there.comparisons.pairs, there.comparisons.pairings) for pair in one.values()}
    assert {name for pair in compared for name in (pair.arm, pair.baseline)} >= names
    assert names <= {*there.paper.static, *there.paper.embodied}
    both = settings_of("cow", "dualmap")
    assert released_cow(both).budget == 250 and released_dualmap(both).side_px == 600


def test_a_section_whose_plugin_is_not_registered_is_said_in_one_line():
    with pytest.raises(TypeError, match="released_cow of type ReleasedCow; section plugins must name its plug-in"):
        released_cow(settings_of("dualmap"))


@pytest.mark.parametrize(
    ("sections", "line"),
    [
        ({COW: {"budgt": 1}}, "released_cow.budgt is not a setting; did you mean budget?"),
        ({COW: {"budget": 0}}, "released_cow.budget is 0; it must be at least 1 (actions, as released)"),
        ({COW: {"commit": "main"}}, 'released_cow.commit is "main"; it must '),
        ({COW: 3}, "released_cow is 3; it must be a section with settings of its own"),
        ({"plugins": {COW: "ovman_released.cow"}}, "plugins.released_cow is ovman_released.cow, which has no PLUGINS of type "),
        ({"plugins": {COW: "nowhere.at_all"}}, "plugins.released_cow is nowhere.at_all, which cannot be imported (No module "),
        ({"plugins": {"x": "ovman_released.plugin"}}, "plugins.x is ovman_released.plugin, which has no plug-in of that name; "),
        ({"plugins": {"x": 3}}, "plugins.x is 3; it must be text"),
        (
            {"arms": {"cow_released": {"made_by": "x"}}},
            "arms.cow_released.made_by is x, which is not in section plugins; the plug",
        ),
    ],
)
def test_a_wrong_setting_of_a_plugin_is_one_line_with_file_key_and_remedy(tmp_path, sections, line):
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump(sections))
    with pytest.raises(ConfigError) as caught:
        load_files([ROOT / "config.yaml", PACKAGE / "cow.yaml", mine])
    said = str(caught.value)
    assert said.startswith(f"mine.yaml: {line}") and "\n" not in said and len(said) < 250


def test_the_snakefile_imports_nothing_heavy_of_it():
    program = (
        "import sys, ovman_released.plugin, ovman_released.settings, ovman_released.notes; "
        "print(*({'numpy', 'ai2thor', 'cv2', 'torch', 'pandas'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_table_of_its_kind_has_a_note_and_no_other_has(tmp_path):
    path = tmp_path / "released_cow.json"
    Note(system="CoW (released)", missing="there is no clone in 50 % of a_place; run: x").write(path)
    settings = settings_of("cow")
    made = Table("Caption.", (Column("a", "a"),), (Group([{"a": "1"}], settings),))
    assert add_notes(made, Kind.STATIC, [path], settings).caption == add_notes(made, None, [path], settings).caption == "Caption."
    after = add_notes(made, Kind.EMBODIED, [path], settings)
    for written in (markdown(after), latex(after, "embodied")):
        assert "Caption. CoW (released) was not run" in " ".join(written.split())
        assert "a_place" not in written
    Note(system="CoW (released)").write(path)
    assert add_notes(made, Kind.EMBODIED, [path], settings).caption == "Caption."
