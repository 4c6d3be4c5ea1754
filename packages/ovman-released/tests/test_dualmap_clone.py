"""What the wrapper relies on, asked of a real clone of DualMap: without weights, without a GPU, skipped where there is none.

DUALMAP_ROOT names the clone, DUALMAP_PYTHON the interpreter of its environment.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from boxes import Box, view
from clone_dualmap import chosen
from settings_of import settings_of

from ovman.perception.backprojection import Camera
from ovman_released.clone import Clone
from ovman_released.dualmap_frames import join, write_visit
from ovman_released.dualmap_runner import GLOBAL, LOCAL, Policy, run
from ovman_released.dualmap_setup import REPOSITORY, Installation
from ovman_released.settings import released_dualmap

ROOT = os.environ.get("DUALMAP_ROOT", "")
LIMIT_S = 1200.0
"""Of one run. The tests have longer, so that the wrapper's own line says what was slow."""
pytestmark = [pytest.mark.skipif(not ROOT, reason="DUALMAP_ROOT names no clone of DualMap"), pytest.mark.timeout(3 * LIMIT_S)]
HERE = Installation(
    Path(ROOT).absolute(),
    Path(os.environ.get("DUALMAP_PYTHON") or sys.executable),
    Path(__file__).with_name("clone_dualmap.py"),
)
PLACES = [(0, 0), (2, 0), (4, 0), (6, 0), (0, 4), (2, 4), (4, 4), (6, 4), (0, 2), (6, 2)]
TEN = [Box((x - 0.25, 0.0, z - 0.25), (x + 0.25, 0.6, z + 0.25), k) for k, (x, z) in enumerate(PLACES)]
WAYPOINTS = [(1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (4.0, 2.0), (5.0, 2.0)]


def walk() -> list[Camera]:
    """A look at the ceiling; then a turn in steps of 30 degrees at every waypoint, and steps of 0.25 m between them."""
    cameras = [Camera((1.0, 1.6, 2.0), 0.0, -80.0, 90.0)]
    for (x, z), (next_x, _) in zip(WAYPOINTS, [*WAYPOINTS[1:], WAYPOINTS[-1]], strict=True):
        cameras += [Camera((x, 1.6, z), 30.0 * k, 20.0, 90.0) for k in range(12)]
        cameras += [Camera((x + 0.25 * k, 1.6, z), 90.0, 20.0, 90.0) for k in range(1, round((next_x - x) / 0.25))]
    return cameras


def mapped(directory: Path, kind: str, boxes: list[Box], preload: Path | None = None):
    write_visit(directory / "v", (view(boxes, camera, 600, 600) for camera in walk()), 0.0)
    settings = join([directory / "v"], directory / "joined", "FloorPlan1")
    policy = Policy(kind, "first_only", "cpu", LIMIT_S, seed=0)
    return run(HERE, policy, settings, "FloorPlan1", ["sofa"], directory / "run", preload)


def test_it_is_the_pinned_commit():
    assert Clone(REPOSITORY, HERE.root, released_dualmap(settings_of("dualmap")).commit).lacks() is None


def test_ten_boxes_are_ten_objects_where_they_are_though_the_first_frame_is_empty(tmp_path):
    found = mapped(tmp_path, LOCAL, TEN)
    names = chosen((HERE.root / "config" / "class_list" / "gpt_indoor_general.txt").read_text().splitlines())
    columns, positions = found.columns, found.mapped(0).object_map().p
    assert sorted(columns["class_name"].tolist()) == sorted(names[:10])
    assert found.nouns["sofa"].shape == (512,)
    for k, (x, z) in enumerate(PLACES):
        here = columns["class_name"].tolist().index(names[k])
        assert positions[here] == pytest.approx((x, z), abs=0.1)
        # The box in DualMap's world, where the second axis is our z and the third our height.
        assert (columns["aabb_min"][here] >= [x - 0.3, z - 0.3, -0.05]).all()
        assert (columns["aabb_max"][here] <= [x + 0.3, z + 0.3, 0.65]).all()
        assert 1 <= columns["first_seen"][here] < columns["last_seen"][here] <= len(walk())


def test_an_old_anchor_keeps_its_name_and_place_beside_the_new_one(tmp_path):
    first = mapped(tmp_path / "1", GLOBAL, TEN[1:3])
    moved = [TEN[1], Box((3.75, 0.0, 3.75), (4.25, 0.6, 4.25), 2)]
    second = mapped(tmp_path / "2", GLOBAL, moved, tmp_path / "1" / "run")
    assert len(first.anchors) == 2 and len(second.anchors) == 3 and set(first.anchors) < set(second.anchors)
    places = {tuple(round(float(v), 1) for v in place) for place in second.mapped(0).object_map().p}
    assert places == {(2.0, 0.0), (4.0, 0.0), (4.0, 4.0)}
