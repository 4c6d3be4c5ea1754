"""What the release keeps is restored as Snakemake and the journals left it: nothing reruns but what a change asks for."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml

from ovman.cli import main
from ovman.doctor.results import Results, check
from ovman.models.settings import Kind, Need, arms_of
from ovman.report import archive, layout, restore
from ovman.report.release import release
from ovman.workflow import made, provenance
from ovman.workflow.config import load_files
from tests.arms import ARMS
from tests.workflow.conftest import ROOT, TINY, World

JUDGED = {"admissibility": {"drift_tolerance_m": 0.26}, "evaluation": {"near_miss_m": 1.6}}
"""Thresholds that judge and change no episode of the tiny world."""
DRIVING = {"scenes", "trials", "rollouts", "walks", "ablated_tours"}
"""Rules that start a simulator, but for `certified`, which starts none where its journal has every run."""
FROM_MAPS = yaml.safe_load((ROOT / "overlays" / "from_maps.yaml").read_text())
CONFIG = ROOT / "config.yaml"


@dataclass(frozen=True)
class Released:
    """The release of the tiny world, and the large archive beside it."""

    folder: Path
    perceived: Path


@pytest.fixture(scope="module")
def released(world, tmp_path_factory) -> Released:
    place = tmp_path_factory.mktemp("released")
    made_of = Released(place / "release", place / "perceived.tar.xz")
    release(world.directory / "results", made_of.folder, "a card", made_of.perceived)
    return made_of


def command(of: Released, directory: Path, *further: str, overlays: Sequence[Path] = ()) -> list[str]:
    files = [str(path) for path in (TINY, *overlays)]
    where = ["--release", str(of.folder), "--directory", str(directory), "--config", str(CONFIG), "--configfile", *files]
    return ["restore", *where, *further]


def restored(of: Released, directory: Path, perceived: bool = True) -> World:
    directory.mkdir()
    further = ["--from", str(of.perceived)] if perceived else []
    assert main(command(of, directory, *further)) == 0
    return World(directory)


def refused(capsys, arguments: Sequence[str], directory: Path) -> str:
    """The one line with which the command refuses, having left no results."""
    assert main(list(arguments)) == 1
    said = capsys.readouterr()
    assert said.out == "" and said.err.count("\n") == 1, said
    assert not any((directory / "results").rglob("*"))
    return said.err


def tables(results: Mapping[str, bytes]) -> dict[str, bytes]:
    return {name: content for name, content in results.items() if name.startswith(("results/tables/", "results/metrics/"))}


def from_measured(of: Released, directory: Path) -> World:
    """Restored without what networks saw, and the tables made under `JUDGED` as `make tables` makes them."""
    again = restored(of, directory, perceived=False)
    before = again.units()
    said = [again.snakemake(overlay=JUDGED, target=target) for target in ("judged", "results/tables")]
    assert [one.returncode for one in said] == [0, 0], said
    ran = {rule for one in said for rule in re.findall(r"^(?:local)?rule (\w+):", one.stdout, re.MULTILINE)}
    assert {"admissible", "sensitivity", "metrics", "tables"} <= ran and not ran & DRIVING
    # What a simulator does is kept in a journal, and there is nothing new in any.
    assert again.units() == before and before
    assert not (directory / "results" / "visits").exists()
    return again


@pytest.mark.parametrize("perceived", [False, True], ids=["measurements", "with what networks saw"])
def test_what_is_restored_is_done_and_whole(world, released, tmp_path, perceived):
    again = restored(released, tmp_path / "again", perceived)
    assert again.planned() == {}
    assert {*check(Results(again.directory, load_files([CONFIG, TINY])))} == set()
    there, made_first = again.results(), world.results()
    assert there == {name: content for name, content in made_first.items() if name in there}
    left = {Path(name).parts[1] for name in made_first.keys() - there.keys()}
    assert left == ({"visits", "walks"} if perceived else {"visits", "walks", *map(top, layout.PERCEIVED)})


def top(part: str) -> str:
    return Path(part).parts[0]


def test_a_changed_threshold_gives_the_tables_of_the_whole_world_without_a_simulator(world, released, tmp_path):
    again = from_measured(released, tmp_path / "again")
    whole = World(shutil.copytree(world.directory, tmp_path / "whole"))
    assert [whole.snakemake(overlay=JUDGED, target=target).returncode for target in ("judged", "results/tables")] == [0, 0]
    assert tables(again.results()) == tables(whole.results()) != tables(world.results())


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_a_changed_threshold_gives_the_tables_of_a_run_from_scratch(released, tmp_path):
    again = from_measured(released, tmp_path / "again")
    (tmp_path / "scratch").mkdir()
    scratch = World(tmp_path / "scratch")
    assert scratch.snakemake(overlay=JUDGED).returncode == 0
    assert tables(again.results()) == tables(scratch.results())


def test_an_agents_threshold_gives_the_static_tables_from_maps_alone(world, released, tmp_path):
    overlay = FROM_MAPS | {"association": {"gate_m": 0.6}}
    target = "results/static_tables"
    again = restored(released, tmp_path / "again")
    assert {*again.planned(overlay, target)} == {"predictions", "static_tables"}
    whole = World(shutil.copytree(world.directory, tmp_path / "whole"))
    for one in (again, whole):
        assert one.snakemake(overlay=overlay, target=target).returncode == 0
    files = [{p.name: p.read_bytes() for p in (one.directory / target).iterdir() if p.suffix} for one in (again, whole)]
    assert files[0] == files[1] and files[0]


def test_the_overlay_of_maps_leaves_out_whoever_needs_more_than_maps():
    more = {arm.name for arm in ARMS if {Need.TOURS, Need.DETECTIONS, Need.SEGMENTS} & {*arm.needs}}
    driven = {arm.name for arm in ARMS if arm.executes in more}
    assert {"arms": dict.fromkeys(more | driven)} == FROM_MAPS
    left = arms_of(load_files([CONFIG, ROOT / "overlays" / "from_maps.yaml"]).arms)
    assert {arm.kind for arm in left} == {*Kind}


@pytest.mark.parametrize("perceived", [False, True])
def test_what_is_not_there_is_planned_where_a_change_needs_it(world, released, tmp_path, perceived):
    overlay: dict[str, Any] = {"association": {"gate_m": 1.3}}
    again = restored(released, tmp_path / "again", perceived)
    planned, of_whole = again.planned(overlay), world.planned(overlay)
    assert of_whole.keys() <= planned.keys() and "trials" in planned and "trials" not in of_whole


DAMAGES = ("trials/FloorPlan227.jsonl", "predictions/two_visits.jsonl", "measurements.tar.xz", "made.jsonl", "parameters.json")


@pytest.mark.parametrize("name", DAMAGES)
def test_a_changed_file_of_the_release_is_refused(released, tmp_path, capsys, name):
    copy = Released(shutil.copytree(released.folder, tmp_path / "release"), released.perceived)
    content = (copy.folder / name).read_bytes()
    (copy.folder / name).write_bytes(content[:-20] + bytes([content[-20] ^ 1]) + content[-19:])
    assert name in refused(capsys, command(copy, tmp_path), tmp_path)


@pytest.mark.parametrize("name", ["tables/main.csv", "parameters.json", "SHA256SUMS"])
def test_a_release_that_lacks_a_file_is_refused(released, tmp_path, capsys, name):
    copy = Released(shutil.copytree(released.folder, tmp_path / "release"), released.perceived)
    name = (
        next(path.relative_to(copy.folder).as_posix() for path in sorted(copy.folder.glob("tables/*"))) if "/" in name else name
    )
    (copy.folder / name).unlink()
    assert name in refused(capsys, command(copy, tmp_path), tmp_path)


@pytest.mark.parametrize("damage", ["changed", "of another release", "torn", "missing"])
def test_a_wrong_archive_is_refused(world, released, tmp_path, capsys, damage):
    place = tmp_path / "perceived.tar.xz"
    file = tmp_path / "results" / "maps" / ("Another.npz" if damage == "of another release" else "FloorPlan227.npz")
    file.parent.mkdir(parents=True)
    file.write_bytes(b"other maps")
    if damage == "torn":
        place.write_bytes(released.perceived.read_bytes()[:-1000])
    elif damage != "missing":
        archive.pack(tmp_path, [file.relative_to(tmp_path).as_posix()], place)
    shutil.rmtree(tmp_path / "results")
    assert str(place) in refused(capsys, command(released, tmp_path, "--from", str(place)), tmp_path)


def test_other_constants_are_refused_and_said(released, tmp_path, capsys):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text("association: {gate_m: 1.3}\n")
    line = refused(capsys, command(released, tmp_path, overlays=[overlay]), tmp_path)
    assert "association.gate_m was 1.25 and is 1.3" in line and "arm " in line


def test_other_code_is_refused_and_said(released, tmp_path, capsys, monkeypatch):
    code = provenance.code_digest
    monkeypatch.setattr(provenance, "code_digest", lambda stage: "another" if stage == "trials" else code(stage))
    assert "stage trials: its code differs;" in refused(capsys, command(released, tmp_path), tmp_path)


def test_another_file_of_the_checkout_is_refused(released, tmp_path):
    sources = made.read(released.folder).sources
    for name in sources:
        (tmp_path / "home" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, tmp_path / "home" / name)
    changed = next(name for name in sources if name.endswith(".yaml"))
    (tmp_path / "home" / changed).write_text("another")
    with pytest.raises(ValueError, match=f"{changed}: is another file;"):
        restore.restore(released.folder, [], tmp_path / "again", load_files([CONFIG, TINY]), tmp_path / "home")
    assert not (tmp_path / "again" / "results").exists()


def test_what_other_constants_made_is_made_again_where_it_is_restored_all_the_same(released, tmp_path):
    overlay = {"evaluation": {"near_miss_m": 1.6}}
    (tmp_path / "overlay.yaml").write_text(yaml.safe_dump(overlay))
    (tmp_path / "again").mkdir()
    assert main(command(released, tmp_path / "again", "--differing", overlays=[tmp_path / "overlay.yaml"])) == 0
    assert {*World(tmp_path / "again").planned(overlay)} == {"metrics", "controls", "tables"}


def test_results_that_are_there_stay(released, tmp_path, capsys):
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "mine").write_text("mine")
    assert main(command(released, tmp_path)) == 1
    assert "is there already" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["mine"]


@pytest.mark.parametrize("fault", ["changed", "no record"])
def test_nothing_is_released_but_what_its_rule_wrote(world, tmp_path, fault):
    results = shutil.copytree(world.directory, tmp_path / "whole") / "results"
    if fault == "changed":
        (results / "admissible" / "FloorPlan227.jsonl").write_text("{}\n")
        line = "results/admissible/FloorPlan227.jsonl: has changed since its rule wrote it"
    else:
        shutil.rmtree(tmp_path / "whole" / ".snakemake" / "metadata")
        line = "there is no record of what made it"
    with pytest.raises(ValueError, match=line):
        release(results, tmp_path / "release", "a card")


def test_an_archive_is_the_same_bytes_whenever_it_is_written(world, tmp_path):
    names = ["results/nouns.npz", "results/scenes/FloorPlan227.json"]
    archive.pack(world.directory, names, tmp_path / "one")
    copies = shutil.copytree(world.directory / "results", tmp_path / "results", copy_function=shutil.copyfile)
    archive.pack(copies.parent, reversed(names), tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
