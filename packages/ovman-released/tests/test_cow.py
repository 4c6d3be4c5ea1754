"""CoW's released runner, by a stand-in with its interface: on the real engine, with the Python of an environment of its own."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from episodes import released
from settings_of import settings_of

import ovman
import ovman_released
from ovman.cache import Cache
from ovman.records.note import Note, sentence
from ovman.records.record import lines
from ovman.settings import Settings
from ovman_released import cow
from ovman_released.clone import Clone
from ovman_released.cow_controller import ARM
from ovman_released.interpreter import environment, linked

STAND_INS = Path(__file__).parent / "stand_ins"
SCENE = "FloorPlan429"

REMOVED = released(f"{SCENE}/removed/0002", spawn={"x": -1.0, "z": -2.75, "yaw_deg": 0.0})
SHIFTED = released(f"{SCENE}/moved/0000", spawn={"x": -0.25, "z": -0.5, "yaw_deg": 270.0})
MOVING = released("FloorPlan201/moving/0027")
SCENES = (SCENE, MOVING.scene)
EPISODES = (SHIFTED, REMOVED, MOVING)


def git(directory: Path, *arguments: str) -> str:
    identity = ("-c", "user.name=n", "-c", "user.email=n@localhost", "-c", "commit.gpgsign=false")
    return subprocess.run(
        ["git", *identity, *arguments], cwd=directory, check=True, capture_output=True, text=True
    ).stdout.strip()


def constants(root: Path, commit: str, python: str, **changed) -> Settings:
    given = {"root": str(root), "commit": commit, "python": python, "device": "cpu", "budget": 6, **changed}
    return settings_of("cow", released_cow=given)


@pytest.fixture(scope="module")
def set_up(tmp_path_factory):
    """A clone at a commit, its interpreter, and the weights: what a user sets up. (root, commit, python, site)."""
    place = tmp_path_factory.mktemp("released")
    root, site = place / "cow", place / "site"
    shutil.copytree(STAND_INS / "cow", root, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(STAND_INS / "site", site, ignore=shutil.ignore_patterns("__pycache__"))
    weights = site / "weights" / "google" / "owlvit-base-patch32"
    weights.mkdir(parents=True)
    for name in ("config.json", "model.safetensors", "preprocessor_config.json"):
        (weights / name).write_text("{}")
    git(root, "init", "--quiet")
    git(root, "add", ".")
    git(root, "commit", "--quiet", "--message", "as released")
    python = place / "python"
    python.write_text(f'#!/bin/sh\nPYTHONPATH="{site}:$PYTHONPATH" exec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    return root, git(root, "rev-parse", "HEAD"), str(python), site


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    place = tmp_path_factory.mktemp("files")
    (place / "main.jsonl").write_text(lines(EPISODES), encoding="utf-8")
    return place / "main.jsonl"


@pytest.fixture(scope="module")
def ran(set_up, files, tmp_path_factory):
    """The records of the stage under two seeds, the status, and the cache."""
    place = tmp_path_factory.mktemp("ran")
    output, cache = place / "rollouts.jsonl", place / "cache"
    cow.run(files, constants(*set_up[:3]), (0, 1), output, place / "status.json", Cache(cache))
    records: dict[int, list] = {seed: [] for seed in (0, 1)}
    for record in map(json.loads, output.read_text().splitlines()):
        records[record["seed"]].append(record)
    return records, place / "status.json", cache


def test_every_episode_under_every_seed_in_the_order_given(ran):
    records, status, _ = ran
    assert Note.load(status).ran and sentence(status) is None
    for seed, of_seed in records.items():
        assert [(r["episode"], r["arm"], r["seed"]) for r in of_seed] == [(h.id, ARM, seed) for h in EPISODES]


def test_a_stop_is_measured_where_it_was_made_and_a_spent_budget_is_not(ran):
    for shifted, removed, moving in ran[0].values():
        assert [r["outcome"] for r in (shifted, removed, moving)] == ["stopped", "budget", "stopped"]
        assert removed["actions"] == 6 and removed["path_length_m"] == 0.0 and removed["stop"] is None
        assert shifted["actions"] == 3 and 0.4 < shifted["path_length_m"] < 0.6
        stop = shifted["stop"]["x"], shifted["stop"]["z"]
        assert math.dist(stop, (SHIFTED.spawn.x, SHIFTED.spawn.z)) == pytest.approx(shifted["path_length_m"], abs=0.02)
        assert shifted["answer_distance_m"] == pytest.approx(math.dist(stop, SHIFTED.answer), abs=1e-3)
        assert shifted["navigable_distance_m"] == pytest.approx(math.dist(stop, SHIFTED.nearest_navigable), abs=1e-3)
        assert set(shifted["visible_px"]) == {"0", "30", "60"}


def test_every_instance_of_the_category_is_measured_for_its_own_task(ran):
    shifted, removed, _ = ran[0][0]
    assert set(shifted["instances"]) == SHIFTED.world_2.ids and "instances" not in removed
    own = shifted["instances"][SHIFTED.target]
    assert (own["box_distance_m"], own["visible_px"]) == (shifted["box_distance_m"], shifted["visible_px"])
    # It stands where it was put, not where it stood, which is more than half a metre nearer.
    (change,) = SHIFTED.changes
    stop = shifted["stop"]["x"], shifted["stop"]["z"]
    before, after = (math.dist(stop, (place.x, place.z)) for place in (change.before, change.after))
    assert before + 0.5 < own["box_distance_m"] < after


def test_the_mover_goes_on_with_the_agents_actions(ran):
    """0.1 m an action at most, from where it was when the run began."""
    for *_, moving in ran[0].values():
        stop = moving["stop"]["x"], moving["stop"]["z"]
        begun = math.dist(stop, MOVING.answer)
        assert 0.0 < abs(moving["answer_distance_m"] - begun) <= 0.3 + 1e-6


def test_the_seed_is_the_runners(ran):
    """Its body's noise differs under another seed, and nowhere else."""
    first, second = (of_seed[0]["stop"] for of_seed in ran[0].values())
    assert first != second and math.dist((first["x"], first["z"]), (second["x"], second["z"])) < 0.2


def test_a_finished_call_is_not_made_again_wherever_the_clone_is_now(ran, set_up, files, tmp_path):
    """The cache answers: an interpreter that cannot run anything is enough."""
    moved = tmp_path / "elsewhere"
    shutil.copytree(set_up[0], moved)
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\ncase "$1" in -c) exec "{set_up[2]}" "$@";; esac\nexit 9\n')
    python.chmod(0o755)
    shutil.copytree(ran[2], tmp_path / "cache")
    output, cache = tmp_path / "rollouts.jsonl", Cache(tmp_path / "cache")
    cow.run(files, constants(moved, set_up[1], str(python)), [1], output, tmp_path / "status.json", cache)
    assert [json.loads(line) for line in output.read_text().splitlines()] == ran[0][1]
    with pytest.raises(RuntimeError, match="status 9"):
        cow.run(files, constants(moved, set_up[1], str(python), budget=5), [1], output, tmp_path / "s.json", cache)


def lacking(set_up, **changed) -> str:
    root, commit, python, _ = set_up
    said = cow.missing(constants(**{"root": root, "commit": commit, "python": python} | changed))
    assert said is not None and "\n" not in said
    return said


def test_nothing_is_missing(set_up):
    assert cow.missing(constants(*set_up[:3])) is None


def test_what_is_missing_is_one_line_with_its_remedy(set_up, tmp_path):
    root, commit, python, site = set_up
    assert f"git clone {cow.REPOSITORY}" in lacking(set_up, root=tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    assert "git clone" in lacking(set_up, root=tmp_path / "empty")
    assert "lies inside another repository" in lacking(set_up, root=root / "src")
    assert f"checkout {'0' * 40}" in lacking(set_up, commit="0" * 40)
    assert "released_cow.python" in lacking(set_up, python="")
    assert "released_cow.python" in lacking(set_up, python=str(tmp_path / "python"))
    assert "no working Python" in lacking(set_up, python=shutil.which("false"))
    assert 'released_cow.device to "cpu"' in lacking(set_up, device="cuda")
    bare = tmp_path / "bare"
    bare.write_text(f'#!/bin/sh\nexec "{sys.executable}" -S "$@"\n')
    bare.chmod(0o755)
    assert "pip install" in lacking(set_up, python=str(bare))


def test_a_changed_clone_is_not_the_released_code(set_up, tmp_path):
    root = tmp_path / "cow"
    shutil.copytree(set_up[0], root)
    (root / "weights.bin").write_text("not tracked")
    assert Clone(cow.REPOSITORY, root, set_up[1]).lacks() is None
    (root / "config_cow.yaml").write_text("max_steps: 1000\n")
    said = Clone(cow.REPOSITORY, root, set_up[1]).lacks()
    assert said.startswith("config_cow.yaml in the clone") and "checkout -- ." in said


def test_without_a_clone_the_records_are_empty_and_the_tables_have_a_note(files, tmp_path):
    output = tmp_path / "rollouts.jsonl"
    given = constants(tmp_path / "nowhere", "0" * 40, sys.executable)
    cow.run(files, given, (0, 1), output, tmp_path / "status.json", Cache(tmp_path / "cache"))
    assert output.read_bytes() == b""
    assert Note.load(tmp_path / "status.json").missing.startswith("there is no clone in")
    assert sentence(tmp_path / "status.json").startswith("CoW (released) was not run")


def test_the_runners_process_needs_no_more_than_it_says(tmp_path):
    """Its environment is the released system's own: only what NEEDS names and its dependencies are imported."""
    of_pydantic = {"annotated_types", "pydantic_core", "typing_extensions", "typing_inspection"}
    program = (
        "import sys; before = set(sys.modules); import ovman_released.cow_process; "
        "names = {name.partition('.')[0] for name in set(sys.modules) - before}; "
        "print(*(name for name in names if name not in sys.stdlib_module_names and not name.startswith('_')))"
    )
    packages = linked(tmp_path / "packages", ovman, ovman_released)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment(packages))
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.split()) - {"ovman", "ovman_released"}
    assert imported == {"numpy", "pydantic"} | of_pydantic and {"numpy", "pydantic"} <= set(cow.NEEDS.modules)
