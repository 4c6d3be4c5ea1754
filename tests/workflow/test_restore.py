"""What the release keeps is restored as Snakemake and the journals left it: nothing reruns but what a change asks for."""

from __future__ import annotations

import hashlib
import json
import lzma
import re
import shutil
import subprocess
import tarfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from ovman.cli import main
from ovman.doctor.results import Results, check
from ovman.report import archive, layout, restore
from ovman.report.release import release
from ovman.settings import Kind, Need, arms_of
from ovman.settings.config import load_files
from ovman.workflow import made, provenance
from ovman.workflow.differences import differences
from tests.arms import ARMS
from tests.workflow.conftest import ROOT, SNAKEMAKE, TINY, World
from tests.workflow.releases import CONFIG, FROM_MAPS, Released, command, restored


def refused(capsys, arguments: Sequence[str], directory: Path) -> str:
    """The one line with which the command refuses, having left no results."""
    assert main(list(arguments)) == 1
    said = capsys.readouterr()
    assert said.out == "" and said.err.count("\n") == 1, said
    assert not any((directory / "results").rglob("*"))
    return said.err


@pytest.mark.parametrize(
    "perceived",
    [pytest.param(False, id="measurements", marks=pytest.mark.soak), pytest.param(True, id="with what networks saw")],
)
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


def test_the_overlay_of_maps_leaves_out_whoever_needs_more_than_maps():
    more = {arm.name for arm in ARMS if {Need.TOURS, Need.DETECTIONS, Need.SEGMENTS} & {*arm.needs}}
    driven = {arm.name for arm in ARMS if arm.executes in more}
    assert {"arms": dict.fromkeys(more | driven)} == FROM_MAPS
    left = arms_of(load_files([CONFIG, ROOT / "overlays" / "from_maps.yaml"]).arms)
    assert {arm.kind for arm in left} == {*Kind}


GATED: Mapping[str, Any] = {"association": {"gate_m": 1.3}}


@pytest.fixture(scope="module")
def of_whole(world):
    """What the changed gate makes again in the whole world."""
    return world.planned(GATED)


@pytest.mark.parametrize("perceived", [False, pytest.param(True, marks=pytest.mark.soak)])
def test_what_is_not_there_is_planned_where_a_change_needs_it(of_whole, released, tmp_path, perceived):
    planned = restored(released, tmp_path / "again", perceived).planned(GATED)
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
    every = list(differences(made.read(released.folder).parameters.values(), load_files([CONFIG, TINY, overlay])))
    assert f"was made otherwise: {min(every)} (and {len(every) - 1} more); " in line
    assert all(one.endswith(": association.gate_m was 1.25 and is 1.3") for one in every)
    assert any(" of arm two_visits: " in one for one in every) and any(" of arm " not in one for one in every)


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
    assert {*World(tmp_path / "again").planned(overlay)} == {"metrics", "controls", "paper_controls", "tables", "all_tables"}


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


def listing(folder: Path, name: str, content: bytes) -> None:
    """Replace a file of a release, and its checksum with it, as somebody does who hands out a release."""
    (folder / name).write_bytes(content)
    sums = (folder / "SHA256SUMS").read_text().splitlines()
    others = [line for line in sums if line.split("  ", 1)[1] != name]
    (folder / "SHA256SUMS").write_text("\n".join([*others, f"{hashlib.sha256(content).hexdigest()}  {name}"]) + "\n")


def hostile(released: Released, tmp_path: Path, change: Callable[[dict[str, Any]], None]) -> Released:
    """A release in whose made.jsonl one more job stands, a changed copy of the first."""
    copy = Released(shutil.copytree(released.folder, tmp_path / "release"), released.perceived)
    lines = (copy.folder / "made.jsonl").read_text().splitlines()
    job = json.loads(lines[0])
    change(job)
    listing(copy.folder, "made.jsonl", "\n".join([*lines, json.dumps(job)]).encode() + b"\n")
    return copy


OUTSIDE = ("results/../../victim.txt", "results/scenes/../../../victim.txt", "{outside}/victim.txt", "../victim.txt", "results")
SHA = hashlib.sha256(b"new").hexdigest()


@pytest.mark.parametrize("name", OUTSIDE)
def test_nothing_is_written_outside_results(released, tmp_path, capsys, name):
    (tmp_path / "victim.txt").write_text("mine")
    place = name.format(outside=tmp_path)
    copy = hostile(released, tmp_path, lambda job: job.update(outputs={place: {"": SHA}}))
    (copy.folder / "victim.txt").write_bytes(b"new")
    (tmp_path / "again").mkdir()
    assert "made.jsonl:" in refused(capsys, command(copy, tmp_path / "again"), tmp_path / "again")
    assert (tmp_path / "victim.txt").read_text() == "mine" and not [*(tmp_path / "again").iterdir()]


@pytest.mark.parametrize("part", ["../../../victim.txt", "{outside}/victim.txt"])
def test_no_file_of_an_output_lies_outside_it(released, tmp_path, capsys, part):
    inner = part.format(outside=tmp_path)
    copy = hostile(released, tmp_path, lambda job: job.update(outputs={"results/tables": {inner: SHA}}))
    assert "made.jsonl:" in refused(capsys, command(copy, tmp_path), tmp_path)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (lambda job: job.pop("outputs"), "outputs"),
        (lambda job: job.update(inputs=7), "inputs"),
        (lambda job: job.update(outputs=[]), "outputs"),
        (lambda job: job.update(parameter="another"), "parameter"),
        (lambda job: job.update(rule={}), "rule"),
    ],
)
def test_a_job_without_its_keys_is_one_line(released, tmp_path, capsys, change, key):
    copy = hostile(released, tmp_path, change)
    assert f": {key}: " in refused(capsys, command(copy, tmp_path), tmp_path)


@pytest.mark.parametrize("kind", ["zeros", "sparse", "long name"])
def test_an_archive_that_unpacks_to_far_more_than_it_has_is_refused(tmp_path, kind):
    """The name of a member is read into memory; a member with holes has no bytes in the archive."""
    place, size = tmp_path / "bomb.tar.xz", 100 << 20
    member = tarfile.TarInfo("results/maps/FloorPlan1.npz")
    member.size = size
    if kind == "long name":
        member.type, member.name = tarfile.GNUTYPE_LONGNAME, "././@LongLink"
    with lzma.open(place, "wb", preset=0) as packed:
        if kind == "sparse":
            header = {"GNU.sparse.major": "0", "GNU.sparse.minor": "1", "GNU.sparse.realsize": str(size)}
            member.pax_headers, member.size = header | {"GNU.sparse.map": f"{size},0"}, 0
        packed.write(member.tobuf(tarfile.PAX_FORMAT if kind == "sparse" else tarfile.GNU_FORMAT))
        for _ in range(member.size >> 20):
            packed.write(bytes(1 << 20))
        packed.write(bytes(1024))
    written: list[int] = []
    with pytest.raises(ValueError, match=r"bomb\.tar\.xz: [^\n]*$"):
        archive.unpack(place, lambda name, content: written.append(len(content.read())))
    assert not written


def test_the_release_of_this_checkout_is_restored_and_a_threshold_plans_few_jobs(tmp_path):
    """In the user's words: `make restore`, another drift tolerance, `snakemake -n results/tables`."""
    assert main(["restore", "--directory", str(tmp_path), "--config", str(ROOT / "config.yaml")]) == 0
    changed = tmp_path / "changed.yaml"
    changed.write_text("admissibility:\n  drift_tolerance_m: 0.15\n")
    command = [*SNAKEMAKE, "--snakefile", str(ROOT / "Snakefile"), "--directory", str(tmp_path), "-n"]
    same, other = (
        subprocess.run([*command, *files, "--", "results/tables"], capture_output=True, text=True, check=True)
        for files in ([], ["--configfile", str(changed)])
    )
    assert "Nothing to be done" in same.stdout + same.stderr
    planned = re.search(r"^total +(\d+)$", other.stdout + other.stderr, re.MULTILINE)
    assert planned and int(planned[1]) <= 60
