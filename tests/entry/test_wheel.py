"""The wheels, installed into an empty folder, away from the checkout: they score."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile

import pytest
import yaml

from ovman.shipped import FILES
from tests.draws.test_draws import DESIGN, TREE
from tests.entry.evaluations import DEPTH
from tests.episodes import DATA, ROOT

BUILT = ("ovman", "packages", "pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE", "NOTICE", "leaderboard")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder that the wheels are unpacked into. They are built from a copy: a build leaves files beside its sources."""
    copy, wheels, target = (tmp_path_factory.mktemp(name) for name in ("copy", "wheels", "target"))
    for name in {*BUILT, *(file.split("/")[0] for file in FILES)}:
        source = ROOT / name
        if source.is_dir():
            left_out = shutil.ignore_patterns("__pycache__", "trials", "scores", "tests", "build")
            shutil.copytree(source, copy / name, ignore=left_out)
        else:
            shutil.copy2(source, copy / name)
    build = [sys.executable, "-c", "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"]
    for folder in (copy, copy / "packages" / "ovman-engine", copy / "packages" / "ovman-client"):
        subprocess.run([*build, str(wheels)], cwd=folder, check=True, capture_output=True, text=True)
    for wheel in wheels.glob("*.whl"):
        zipfile.ZipFile(wheel).extractall(target)
    return target


def test_it_holds_the_files_of_the_checkout(installed):
    for name in (*FILES, "leaderboard"):
        source, inside = ROOT / name, installed / "ovman" / "shipped" / name
        files = [path for path in source.rglob("*") if path.is_file()] if source.is_dir() else [source]
        assert files
        for path in files:
            assert (inside / path.relative_to(source)).read_bytes() == path.read_bytes()


@pytest.fixture
def options(installed, tmp_path):
    """Options of a process that has the wheels alone."""
    environment = {name: value for name, value in os.environ.items() if name in ("PATH", "LANG", "OMP_NUM_THREADS")}
    environment |= {"HOME": str(tmp_path), "PYTHONPATH": str(installed), "PYTHONNOUSERSITE": "1"}
    return {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True, "check": False}


def test_it_draws_and_evaluates_where_it_is_installed(options, tmp_path):
    (tmp_path / "settings.yaml").write_text(yaml.safe_dump(TREE, sort_keys=False))
    for words in (
        ["draw", "--seed", "wheel", *map(str, DESIGN), "--out", "drawn"],
        ["eval", "--arm", DEPTH, "--episodes", "drawn"],
    ):
        words += ["--config", "settings.yaml"] + ["--out", "out"] * (words[0] == "eval")
        done = subprocess.run([sys.executable, "-m", "ovman.cli", *words], **options)
        assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["draw"].startswith("own-")


def test_it_scores_where_it_is_installed(installed, options, tmp_path):
    shutil.copy2(DATA / "predictions" / "main" / "two_visits.jsonl", tmp_path / "points.jsonl")
    done = subprocess.run([sys.executable, "-m", "ovman.cli", "score", "points.jsonl", "--json"], **options)
    assert done.returncode == 0, done.stderr
    scored = json.loads(done.stdout)
    assert scored["whole"] and scored["released"] and scored["tests"]
    where = "import ovman, ovman_engine, ovman_client as client; print(ovman.__file__, ovman_engine.__file__, client.__file__)"
    assert subprocess.run([sys.executable, "-c", where], **options).stdout.count(str(installed)) == 3
