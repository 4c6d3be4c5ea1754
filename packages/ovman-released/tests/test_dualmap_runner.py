"""Runs of DualMap in a process of their own, against a clone that stands in for it, with its outside and its faults."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from boxes import Box, spin, view

from ovman_released import dualmap_process
from ovman_released.dualmap_frames import join, write_visit
from ovman_released.dualmap_objects import ObjectsError, read_objects
from ovman_released.dualmap_runner import GLOBAL, LOCAL, Policy, RunError, overrides, report, run
from ovman_released.dualmap_setup import Installation

SOFA, CUP, LAMP = 0, 1, 2
BOXES = [Box((0.6, 0.0, 1.6), (1.4, 0.6, 2.2), SOFA), Box((0.9, 0.6, 1.8), (1.0, 0.75, 1.9), CUP)]
MOVED = [Box((-1.6, 0.0, 1.6), (-0.8, 0.6, 2.2), SOFA), BOXES[1]]
HERE = Installation(Path(__file__).parent / "stand_ins" / "dualmap", Path(sys.executable))
NOUNS = ["sofa", "house plant"]


def policy(kind: str = LOCAL, guard: str = "first_only", limit_s: float = 60.0, seed: int | None = 0) -> Policy:
    return Policy(kind, guard, "cpu", limit_s, seed)


def sequence(directory: Path, scene_id: str = "FloorPlan1", *worlds: list[Box]) -> Path:
    """A sequence of visits: a turn on the spot in every world. The first frames look away from all boxes."""
    for number, boxes in enumerate(worlds or [BOXES]):
        cameras = spin(0.0, 0.0)[6:] + spin(0.0, 0.0)[:6]
        write_visit(directory / f"v{number}", (view(boxes, camera) for camera in cameras), 0.0)
    return join(sorted(directory.glob("v*")), directory / "joined", scene_id)


def test_from_frames_to_objects_in_our_world(tmp_path):
    settings = sequence(tmp_path)
    assert not view(BOXES, spin(0.0, 0.0)[6]).rgb.any(), "the first frame is empty, which ends DualMap without the guard"
    objects = run(HERE, policy(), settings, "FloorPlan1", NOUNS, tmp_path / "run")
    assert sorted(objects.columns["class_name"].tolist()) == ["cup", "sofa"]
    found = dict(zip(objects.columns["class_name"].tolist(), objects.mapped(12).object_map().p, strict=True))
    # Two sides and the top of each box are seen from here, so that the boxes are whole on the floor plane.
    assert found["sofa"] == pytest.approx(BOXES[0].centre[::2], abs=0.05)
    assert found["cup"] == pytest.approx(BOXES[1].centre[::2], abs=0.05)
    assert objects.columns["kind"].tolist() == ["local"] * 2
    seen = sorted(zip(objects.columns["first_seen"].tolist(), objects.columns["last_seen"].tolist(), strict=True))
    assert all(1 < first < last <= 12 for first, last in seen), "keyframes count from 1, and the first ones show nothing"
    assert objects.nouns.keys() == set(NOUNS)
    assert objects.nouns["sofa"].tolist() == np.eye(8)[4].tolist()
    assert np.linalg.norm(objects.mapped(12).object_map().f, axis=1) == pytest.approx(1)
    assert report(tmp_path / "run").keyframes == 12 and report(tmp_path / "run").saved["local"] == 2


def test_keys_of_the_records(tmp_path):
    run(HERE, policy(GLOBAL), sequence(tmp_path), "FloorPlan1", NOUNS, tmp_path / "run")
    with np.load(tmp_path / "run" / "objects.npz", allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    assert {"uid", "class_id", "class_name", "center_xyz", "aabb_min", "aabb_max", "n_points", "clip_ft", "kind"} <= arrays.keys()
    assert arrays["kind"].tolist() == ["anchor", "related"] and arrays["class_name"].tolist() == ["sofa", "cup"]
    assert arrays["center_xyz"] == pytest.approx((arrays["aabb_min"] + arrays["aabb_max"]) / 2)
    assert arrays["n_points"][0] > 0 and arrays["n_points"][1] == 0
    assert arrays["uid"][1] == f"{arrays['uid'][0]}/0", "what is on an anchor is called after it"
    assert arrays["clip_ft"].dtype == np.float32 and arrays["clip_ft"].tolist() == np.eye(8)[[SOFA, CUP]].tolist()


def test_the_mode_decides_what_is_saved(tmp_path):
    local, whole = (overrides(policy(kind), tmp_path / "s.yaml", "s", tmp_path / "o") for kind in (LOCAL, GLOBAL))
    assert {"run_local_mapping_only=true", "save_local_map=true", "save_global_map=false"} <= set(local)
    assert {"run_local_mapping_only=false", "save_local_map=false", "save_global_map=true"} <= set(whole)
    always = {"dataset_name=self_collected", "scene_id=s", "use_stride=false", "use_rerun=false"}
    assert always <= set(local) & set(whole)


def test_as_released_it_runs_in_parallel_unseeded_and_on_the_gpu(tmp_path):
    released = overrides(Policy(LOCAL, "first_only", "cuda", 60.0), tmp_path / "s.yaml", "s", tmp_path / "o")
    assert not [text for text in released if text.startswith(("use_parallel", "device", "use_fastsam"))]
    tested = overrides(policy(), tmp_path / "s.yaml", "s", tmp_path / "o")
    assert {"use_parallel=false", "device=cpu", "use_fastsam=false"} <= set(tested)
    with pytest.raises(ValueError, match="only a global map"):
        overrides(policy(LOCAL), tmp_path / "s.yaml", "s", tmp_path / "o", tmp_path / "p")


def test_equal_seeds_give_equal_maps_though_ids_are_random(tmp_path):
    settings = sequence(tmp_path, "s")
    a, b = (run(HERE, policy(), settings, "s", NOUNS, tmp_path / name) for name in "ab")
    assert a.columns["uid"].tolist() != b.columns["uid"].tolist()
    for name in set(a.columns) - {"uid"}:
        assert np.array_equal(a.columns[name], b.columns[name]), name


def test_one_map_through_two_visits_holds_both_places(tmp_path):
    objects = run(HERE, policy(), sequence(tmp_path, "s", BOXES, MOVED), "s", [], tmp_path / "run")
    assert report(tmp_path / "run").keyframes == 24, "time goes on from one visit to the next"
    assert objects.columns["last_seen"].max() > 12


def test_an_anchor_survives_the_preload(tmp_path):
    first = run(HERE, policy(GLOBAL), sequence(tmp_path / "1", "s", BOXES), "s", [], tmp_path / "run1")
    second = run(HERE, policy(GLOBAL), sequence(tmp_path / "2", "s", MOVED), "s", [], tmp_path / "run2", tmp_path / "run1")
    assert len(second.anchors) == 2 and set(first.anchors) < set(second.anchors)
    kept = second.columns["uid"].tolist().index(first.anchors[0])
    assert second.columns["center_xyz"][kept] == pytest.approx(first.columns["center_xyz"][0])


def test_a_preload_that_was_not_loaded_is_an_error(tmp_path):
    run(HERE, policy(GLOBAL), sequence(tmp_path / "1", "s", BOXES), "s", [], tmp_path / "run1")
    with pytest.raises(RunError, match="forgets: 1 anchors of the preloaded map are gone"):
        run(HERE, policy(GLOBAL), sequence(tmp_path / "2", "forgets", MOVED), "forgets", [], tmp_path / "run2", tmp_path / "run1")


def test_a_map_without_objects_is_an_error_that_names_the_scene(tmp_path):
    with pytest.raises(RunError, match=r"FloorPlan7: no object stayed in its local map in 12 keyframes; walk more densely"):
        run(HERE, policy(), sequence(tmp_path, "FloorPlan7", []), "FloorPlan7", NOUNS, tmp_path / "run")


@pytest.mark.parametrize(
    ("scene_id", "says"),
    [
        ("half_built", "half_built: the detector is not complete: weights did not load"),
        ("raises", "raises: RuntimeError: something went wrong in DualMap"),
        ("killed", "killed: ended with status -9"),
    ],
)
def test_a_run_that_fails_says_why_and_ends_though_a_thread_goes_on(tmp_path, scene_id, says):
    with pytest.raises(RunError, match=says):
        run(HERE, policy(), sequence(tmp_path, scene_id), scene_id, NOUNS, tmp_path / "run")


def test_a_run_that_hangs_is_killed(tmp_path):
    with pytest.raises(RunError, match="hangs: ended after 2 s without a map"):
        run(HERE, policy(limit_s=2.0), sequence(tmp_path, "hangs"), "hangs", NOUNS, tmp_path / "run")
    said = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    assert str(tmp_path) not in said


def test_what_a_killed_run_had_said_is_in_its_log(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)
    with pytest.raises(RunError, match="hangs: ended after 6 s"):
        run(HERE, policy(limit_s=6.0), sequence(tmp_path, "hangs"), "hangs", NOUNS, tmp_path / "run")
    said = (tmp_path / "run" / "dualmap.log").read_text()
    assert "Use FastSAM" in said and "frame 1 of 12" in said


def test_a_run_that_nobody_waits_for_any_more_ends_and_says_so(tmp_path):
    """Its runner was killed with all that it was part of: a test, a job, a shell."""
    settings = sequence(tmp_path, "hangs")
    program = (
        "import sys; from pathlib import Path; import test_dualmap_runner as here; "
        "settings, directory = map(Path, sys.argv[1:]); "
        "here.run(here.HERE, here.policy(), settings, 'hangs', here.NOUNS, directory)"
    )
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    runner = subprocess.Popen([sys.executable, "-c", program, str(settings), str(tmp_path / "run")], env=env)
    log, error = tmp_path / "run" / "dualmap.log", tmp_path / "run" / "error.txt"
    try:
        until(lambda: log.is_file() and "frame 1 of 12" in log.read_text())
    finally:
        runner.kill()
        runner.wait()
    until(error.is_file)
    assert error.read_text() == "ended without a map, because the process that started it has ended\n"
    until(lambda: str(tmp_path) not in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout)


def until(there: Callable[[], bool]) -> None:
    for _ in range(300):
        if there():
            return
        time.sleep(0.1)
    raise TimeoutError("it did not come in 30 s")


def test_the_clone_stays_as_it_was(tmp_path):
    clone = shutil.copytree(HERE.root, tmp_path / "clone", ignore=shutil.ignore_patterns("__pycache__"))

    def files():
        return {path: path.stat().st_mtime_ns for path in clone.rglob("*")}

    before = files()
    run(replace(HERE, root=clone), policy(), sequence(tmp_path), "FloorPlan1", NOUNS, tmp_path / "run")
    assert files() == before
    assert (tmp_path / "run" / "classes.txt").read_bytes() == (HERE.root / "config" / "classes.txt").read_bytes()


def test_a_path_with_odd_characters_is_one_setting(tmp_path):
    odd = tmp_path / "it's = a, path"
    odd.mkdir()
    assert len(run(HERE, policy(), sequence(odd), "FloorPlan1", [], odd / "run")) == 2


@pytest.mark.parametrize("content", [b"", b"not an archive"])
def test_a_file_that_holds_no_objects(tmp_path, content):
    (tmp_path / "objects.npz").write_bytes(content)
    with pytest.raises(ObjectsError, match="no readable file of objects"):
        read_objects(tmp_path / "objects.npz")
    with pytest.raises(ObjectsError, match="run DualMap again"):
        read_objects(tmp_path / "none.npz")


def test_the_process_needs_no_more_than_dualmaps_python():
    """Its modules are Python 3.10, and import its library, NumPy and one another."""
    allowed = sys.stdlib_module_names | {"numpy", ""}
    for path in Path(dualmap_process.__file__).parent.glob("*.py"):
        tree = ast.parse(path.read_bytes(), feature_version=(3, 10))
        for node in ast.walk(tree):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
            assert {name.partition(".")[0] for name in names} <= allowed, path.name
