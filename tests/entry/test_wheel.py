"""The wheels, installed into an empty folder, away from the checkout: their commands work."""

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
from tests.entry.evaluations import ASKED, DEPTH, SCENE
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
    build = [shutil.which("uv") or str(ROOT / ".uv" / "bin" / "uv"), "build", "--wheel", "--quiet", "--out-dir", str(wheels)]
    for folder in (copy, copy / "packages" / "ovman-engine", copy / "packages" / "ovman-client"):
        subprocess.run([*build, "."], cwd=folder, check=True, capture_output=True, text=True)
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
def run(installed, tmp_path):
    """Run the installed command in an empty folder, with an empty home and nothing of the checkout in sight."""
    environment = {name: value for name, value in os.environ.items() if name in ("PATH", "LANG", "OMP_NUM_THREADS")}
    environment |= {"HOME": str(tmp_path / "home"), "PYTHONPATH": str(installed), "PYTHONNOUSERSITE": "1"}
    (tmp_path / "home").mkdir()

    def run(*words):
        command = [sys.executable, *words] if words[0] == "-c" else [sys.executable, "-m", "ovman.cli", *words]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_it_scores_where_it_is_installed(installed, run, tmp_path):
    shutil.copy2(DATA / "predictions" / "main" / "two_visits.jsonl", tmp_path / "points.jsonl")
    scored = json.loads(run("score", "points.jsonl", "--json"))
    assert scored["whole"] and scored["released"] and scored["tests"]
    where = "import ovman, ovman_engine, ovman_client as client; print(ovman.__file__, ovman_engine.__file__, client.__file__)"
    assert run("-c", where).count(str(installed)) == 3


def test_it_evaluates_verifies_and_shows_where_it_is_installed(run, tmp_path):
    score = json.loads(
        run("eval", "--arm", DEPTH, "--split", "main", "--scenes", SCENE, "--seeds", "0", "--out", "out", "--json")
    )
    assert score["asked"] == ASKED and score["arm"] == DEPTH
    assert json.loads(run("verify", "out", "--json"))["agrees"]
    episode = json.loads(run("episodes", "--scenes", SCENE, "--json"))[0]
    page = tmp_path / run("show", episode["episode"], "--runs", "out", "--output", "page.html").strip()
    assert episode["sentence"] in page.read_text(encoding="utf-8")


def test_it_draws_homes_where_it_is_installed(run, tmp_path):
    (home,) = json.loads(run("homes", "--seed", "3", "--out", "homes", "--json"))
    assert (tmp_path / "homes" / f"{home['name']}.json").is_file() and (tmp_path / "homes" / "homes.png").is_file()


def test_it_draws_and_evaluates_where_it_is_installed(run, tmp_path):
    (tmp_path / "settings.yaml").write_text(yaml.safe_dump(TREE, sort_keys=False))
    settings = "--config", "settings.yaml"
    run("draw", "--seed", "wheel", *map(str, DESIGN), "--out", "drawn", *settings)
    run("eval", "--arm", DEPTH, "--episodes", "drawn", "--out", "out", *settings)
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["draw"].startswith("own-")
    assert json.loads(run("verify", "drawn", "--json", *settings))["agrees"]
