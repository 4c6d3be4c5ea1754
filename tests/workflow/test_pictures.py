"""A change of the engine that alters pictures and no record: what reads pictures is made again, and nothing else.

The engine is changed in a copy of the checkout, which goes on with a copy of the finished world.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path

import pytest

from ovman.settings import Kind, Need, arms_of, of_kind
from ovman.settings.config import load_files
from tests.workflow.conftest import ROOT, TINY, World

pytestmark = pytest.mark.soak
EPISODES = "results/episodes/main.jsonl"
CODE = ("Snakefile", "config", "config.yaml", "overlays", "ovman", "packages", "profiles", "workflow")
UNCHANGED = ("scenes", "candidates", "trials", "admissible", "certified", "episodes")
"""Stages that start the engine or follow it, and whose records have no picture in them."""
SEEING = {Need.TOURS, Need.MAPS, Need.MAINTAINED, Need.DUALMAP, Need.SEGMENTS}


def checkout(directory: Path) -> Path:
    """A copy of the code in a directory, with its compiled kernels: no kernel is of a tone. Models are linked."""
    directory.mkdir()
    for name in CODE:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, directory / name, ignore=shutil.ignore_patterns("*.egg-info"))
        else:
            shutil.copy2(source, directory / name)
    (directory / "models").symlink_to(ROOT / "models")
    return directory


def repaint(code: Path) -> None:
    """Give wood another hue. The file keeps its size and its time, so that the compiled kernels hold."""
    path = code / "packages" / "ovman-engine" / "ovman_engine" / "paint" / "tones.py"
    text = path.read_text()
    woods = re.search(r"WOODS.*?\n\)", text, re.DOTALL)
    assert woods
    repainted = re.sub(r"\(0\.(\d+), ", lambda hue: f"({(float('0.' + hue[1]) + 0.5) % 1.0:.3f}, ", woods[0])
    assert repainted != woods[0] and len(repainted) == len(woods[0])
    before = path.stat()
    path.write_text(text.replace(woods[0], repainted))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    for compiled in path.parent.glob("__pycache__/tones.*.pyc"):  # Python tells by size and time, too
        compiled.unlink()


def records(world: World, stage: str) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((world.directory / "results" / stage).glob("*.json*"))}


@pytest.fixture(scope="module")
def repainted(world, tmp_path_factory):
    """The finished world after `make tables` has made its episodes with the changed engine; the world before, the first plan."""
    place = tmp_path_factory.mktemp("repainted")
    shutil.copytree(world.directory, place / "world", symlinks=True)
    again = World(place / "world", checkout(place / "code"))
    said = again.snakemake("--touch", "--forceall")  # weights and sentences lie in another checkout now
    assert said.returncode == 0, said.stdout
    assert again.planned() == {}
    repaint(again.checkout)
    said = again.snakemake(target=EPISODES)
    assert said.returncode == 0, said.stdout
    return again


def test_the_records_are_the_same_and_the_manifest_is_another(world, repainted):
    for stage in UNCHANGED:
        assert records(repainted, stage) == records(world, stage), stage
    was, now = (json.loads(records(one, "visits")["FloorPlan227.json"])["visits"] for one in (world, repainted))
    assert was.keys() == now.keys() and not set(was.values()) & set(now.values())


def test_what_reads_pictures_is_made_again_and_nothing_else(repainted):
    said = repainted.snakemake("--dry-run")
    assert said.returncode == 0, said.stdout
    planned = set(re.findall(r"^(?:local)?rule (\w+):", said.stdout, re.MULTILINE))
    driven = {"walks", "rollouts", "scores"}  # these start the engine themselves
    seeing = {"detections", "segments", "labels", "maps", "maintained", "predictions", "language", "perception", "backprojection"}
    seeing |= {"fragments", "probes", "readmitted_maps", "readmitted_predictions", "sensitivity"}
    seeing |= {"cues", "appearance", "split_metrics", "split_scores", "split_embodied_metrics", "controls"}
    assert planned == driven | seeing | {"dualmap", "dualmap_objects", "metrics", "tables"}
    answers = set(re.findall(r"output: results/predictions/(\w+)\.jsonl", said.stdout))
    arms = arms_of(load_files([ROOT / "config.yaml", TINY]).arms)
    assert answers == {arm.name for arm in of_kind(arms, Kind.STATIC) if SEEING & set(arm.needs)}


def test_the_tables_are_those_of_a_world_that_was_made_with_the_changed_engine(repainted, tmp_path):
    fresh = World(tmp_path, repainted.checkout)
    for one in (repainted, fresh):
        said = one.snakemake()
        assert said.returncode == 0, said.stdout
        assert one.planned() == {}
    assert repainted.results() == fresh.results()
