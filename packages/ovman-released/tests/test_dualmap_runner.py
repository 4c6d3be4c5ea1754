"""Runs of DualMap in a process of their own, against a clone that stands in for it, with its outside and its faults."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from boxes import Box, spin, view

from ovman_released import dualmap_process
from ovman_released.dualmap_frames import join, write_visit
from ovman_released.dualmap_objects import ObjectsError, read_objects
from ovman_released.dualmap_runner import GLOBAL, LOCAL, Policy, RunError, report, run
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


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """The objects of a finished run, its settings, and its folder."""
    place = tmp_path_factory.mktemp("local")
    settings = sequence(place)
    return run(HERE, policy(), settings, "FloorPlan1", NOUNS, place / "run"), settings, place / "run"


@pytest.fixture(scope="module")
def anchored(tmp_path_factory):
    """The objects of a finished run with a global map, and its folder."""
    place = tmp_path_factory.mktemp("anchored")
    return run(HERE, policy(GLOBAL), sequence(place, "s", BOXES), "s", [], place / "run"), place / "run"


def test_from_frames_to_objects_in_our_world(local):
    objects, _, folder = local
    assert not view(BOXES, spin(0.0, 0.0)[6]).rgb.any(), "the first frame is empty, which ends DualMap without the guard"
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
    assert report(folder).keyframes == 12 and report(folder).saved["local"] == 2


def test_equal_seeds_give_equal_maps_though_ids_are_random(local, tmp_path):
    a, settings, _ = local
    b = run(HERE, policy(), settings, "FloorPlan1", NOUNS, tmp_path / "run")
    assert a.columns["uid"].tolist() != b.columns["uid"].tolist()
    for name in set(a.columns) - {"uid"}:
        assert np.array_equal(a.columns[name], b.columns[name]), name


def test_an_anchor_survives_the_preload(anchored, tmp_path):
    first, folder = anchored
    second = run(HERE, policy(GLOBAL), sequence(tmp_path, "s", MOVED), "s", [], tmp_path / "run", folder)
    assert len(second.anchors) == 2 and set(first.anchors) < set(second.anchors)
    kept = second.columns["uid"].tolist().index(first.anchors[0])
    assert second.columns["center_xyz"][kept] == pytest.approx(first.columns["center_xyz"][0])


def test_a_preload_that_was_not_loaded_is_an_error(anchored, tmp_path):
    with pytest.raises(RunError, match="forgets: 1 anchors of the preloaded map are gone"):
        run(HERE, policy(GLOBAL), sequence(tmp_path, "forgets", MOVED), "forgets", [], tmp_path / "run", anchored[1])


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
