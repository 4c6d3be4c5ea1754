"""The wheels, installed into an empty folder, away from the checkout: they score, evaluate, verify and show."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ovman.shipped import FILES
from ovman_engine import kernels
from tests.entry.evaluations import DEPTH, SCENE
from tests.episodes import DATA, ROOT

BUILT = ("ovman", "packages", "pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE", "NOTICE", "leaderboard")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder that the wheels are installed into. They are built from a copy: a build leaves files beside its sources."""
    copy, wheels, target = (tmp_path_factory.mktemp(name) for name in ("copy", "wheels", "target"))
    for name in {*BUILT, *(file.split("/")[0] for file in FILES)}:
        source = ROOT / name
        if source.is_dir():
            left_out = shutil.ignore_patterns("__pycache__", "trials", "scores", "tests", "build")
            shutil.copytree(source, copy / name, ignore=left_out)
        else:
            shutil.copy2(source, copy / name)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input"]
    offline = ["--no-deps", "--no-index"]
    folders = [str(folder) for folder in (copy, copy / "packages" / "ovman-engine", copy / "packages" / "ovman-client")]
    done = [*pip, "wheel", *offline, "--no-build-isolation", "--wheel-dir", str(wheels), *folders]
    subprocess.run(done, check=True, capture_output=True, text=True)
    names = [str(wheel) for wheel in sorted(wheels.glob("*.whl"))]
    subprocess.run([*pip, "install", *offline, "--target", str(target), *names], check=True, capture_output=True, text=True)
    lay_kernels(target / "ovman_engine")
    return target


def lay_kernels(package):
    """Lay the kernels that the checkout's engine has compiled beside the sources of the wheel's, where these are the same bytes.

    Compiling them takes a minute of the processor. They are known by the time and the size of a source.
    """
    kernels.compile_once()
    here = Path(kernels.__file__).parent
    for kept in [*here.rglob("*.nbi"), *here.rglob("*.nbc"), *here.glob("__pycache__/kernels-*")]:
        place = package / kept.relative_to(here)
        place.parent.mkdir(exist_ok=True)
        shutil.copy2(kept, place)
    for source in here.rglob("*.py"):
        inside = package / source.relative_to(here)
        if inside.read_bytes() == source.read_bytes():
            shutil.copystat(source, inside)


@pytest.fixture(scope="module")
def away(installed, tmp_path_factory):
    """Runs `ovman` of the wheels in an empty folder with an empty home; returns the folder and the function."""
    here = tmp_path_factory.mktemp("away")
    environment = {name: value for name, value in os.environ.items() if name in ("PATH", "LANG", "OMP_NUM_THREADS")}
    environment |= {"HOME": str(here), "PYTHONPATH": str(installed), "PYTHONNOUSERSITE": "1"}

    def run(*options):
        command = [sys.executable, "-m", "ovman.cli", *map(str, options)]
        return subprocess.run(command, cwd=here, env=environment, capture_output=True, text=True, check=False)

    return here, run


def test_a_wheel_is_where_it_is_installed(installed, away):
    here, run = away
    done = run("--version")
    assert done.returncode == 0, done.stderr
    where = subprocess.run(
        [sys.executable, "-c", "import ovman, ovman_engine, ovman_client; print(ovman.__file__, ovman_engine.__file__)"],
        env={"PYTHONPATH": str(installed)},
        cwd=here,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert where.count(str(installed)) == 2 and str(ROOT) not in where.replace(str(installed), "")


def test_it_holds_the_files_of_the_checkout(installed):
    for name in (*FILES, "leaderboard"):
        source, inside = ROOT / name, installed / "ovman" / "shipped" / name
        files = [path for path in source.rglob("*") if path.is_file()] if source.is_dir() else [source]
        assert files
        for path in files:
            assert (inside / path.relative_to(source)).read_bytes() == path.read_bytes()


def test_it_scores(away):
    here, run = away
    shutil.copy2(DATA / "predictions" / "main" / "two_visits.jsonl", here / "points.jsonl")
    done = run("score", "points.jsonl", "--json")
    assert done.returncode == 0, done.stderr
    scored = json.loads(done.stdout)
    assert scored["whole"] and scored["released"] and scored["tests"]


@pytest.mark.soak
def test_it_evaluates_verifies_and_shows(away, depth_driving, tours):
    """The tours that the checkout has recorded are those that it needs: they are keyed by the code."""
    here, run = away
    options = ["--split", "main", "--scenes", SCENE, "--seeds", "0", "1"]
    done = run("eval", "--arm", DEPTH, *options, "--out", "mine", "--cache", tours)
    assert done.returncode == 0, done.stderr
    assert (here / "mine" / "runs.jsonl").read_bytes() == (depth_driving / "runs.jsonl").read_bytes()
    code = [json.loads((folder / "manifest.json").read_text())["code"] for folder in (here / "mine", depth_driving)]
    assert code[0] == code[1]
    done = run("verify", "mine")
    assert done.returncode == 0 and "all 4 runs agree" in done.stdout, done.stdout + done.stderr
    done = run("show", f"{SCENE}/moved/0001")
    assert done.stdout.strip() == f"pages/{SCENE}/moved/0001.html", done.stderr
    assert "<!DOCTYPE html>" in (here / "pages" / SCENE / "moved" / "0001.html").read_text()
