from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.instances import TrueObject, TrueScene
from ovman.analysis.localisation import box_distance_m, centre_distance_m, localised
from ovman.analysis.segmentation import DETECTED, TRUE
from ovman.perception.backprojection import Camera, median_point, single_ray_point, world_points
from ovman.records.visit import TourError
from tests.analysis.recordings import MIN_MASK_PX, SIDE, detected, mask, write_scene, write_visit

CAMERA = Camera((0.0, 1.5, 0.0), 0.0, 0.0, 90.0)
BOX = TrueObject("Box|1", "Box", (1.0, 2.0, 3.0), (0.2, 0.4, 0.6))


def wall_on_the_right(side=200):
    """Depth (H, W) of the plane x = 1, infinite where the camera does not see it, and the heights above the camera."""
    u = (np.arange(side) + 0.5 - side / 2) / (side / 2)
    depth = np.where(u > 0, 1 / np.maximum(u, 1e-9), np.inf)[None, :].repeat(side, axis=0)
    return depth, -u[:, None] * depth


def around(points, thickness=1e-6):
    low, high = points.min(axis=0) - thickness, points.max(axis=0) + thickness
    return TrueObject("L|1", "L", tuple((low + high) / 2), tuple(high - low))


def test_the_single_ray_is_worse_on_an_l():
    depth, height = wall_on_the_right()
    upright = (depth < 1.6) & (abs(height) < 0.8)
    lying = (depth < 9) & (height < -0.5) & (height > -0.8)
    mask = (upright | lying) & (depth > 1.1)
    box = around(world_points(depth, mask, CAMERA))
    assert box_distance_m(median_point(depth, mask, CAMERA), box) == 0.0
    assert box_distance_m(single_ray_point(depth, mask, CAMERA), box) > 0.03


@given(st.integers(0, 2**32 - 1))
def test_the_median_never_leaves_the_box_of_what_is_seen(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((12, 12)) < rng.uniform(0.05, 1)
    mask[rng.integers(12), rng.integers(12)] = True
    depth = rng.choice([0.4, 2.0, 20.0], mask.shape) * rng.uniform(0.9, 1.1, mask.shape)
    camera = Camera(tuple(rng.normal(size=3)), rng.uniform(0, 360), rng.uniform(-30, 60), 90.0)
    assert box_distance_m(median_point(depth, mask, camera), around(world_points(depth, mask, camera))) == 0.0


@pytest.mark.parametrize(
    ("point", "box_m", "centre_m"),
    [
        ((1.0, 2.0, 3.0), 0.0, 0.0),
        ((1.1, 2.2, 3.3), 0.0, np.hypot(0.1, 0.3)),
        ((1.4, 2.0, 3.0), 0.3, 0.4),
        ((1.0, 9.2, 3.0), 7.0, 0.0),
        ((1.4, 2.6, 3.0), 0.5, 0.4),
    ],
)
def test_distances(point, box_m, centre_m):
    assert box_distance_m(np.array(point), BOX) == pytest.approx(box_m, abs=1e-12)
    assert centre_distance_m(np.array(point), BOX) == pytest.approx(centre_m, abs=1e-12)


def test_true_and_detected_masks_of_a_tour(tmp_path):
    scene = TrueScene.load(write_scene(tmp_path))
    directory = write_visit(tmp_path / "untouched")
    seen = detected([mask("Sofa|1", 2), ~mask("Sofa|1"), mask("Vase|2")], views=[0, 0, 1])
    rows = list(localised(scene, directory, 90.0, MIN_MASK_PX, seen))
    assert [(r.view, r.mask, r.object) for r in rows] == [
        (0, TRUE, "Sofa|1"), (0, TRUE, "Vase|1"), (0, DETECTED, "Sofa|1"),
        (1, TRUE, "Sofa|1"), (1, TRUE, "Vase|1"), (1, DETECTED, "Vase|2"),
    ]  # fmt: skip
    left, right = 4, 34
    centre_x = ((left + right) / 2 - SIDE / 2) / (SIDE / 2) * 2.0
    assert rows[0].median_centre_m == pytest.approx(abs(centre_x - 0.0), abs=1e-9)
    assert rows[0].px == mask("Sofa|1").sum()
    assert {r.scene for r in rows} == {"FloorPlan1"} and all(r.category == r.object.split("|")[0] for r in rows)
    assert list(localised(scene, directory, 90.0, MIN_MASK_PX, None)) == [r for r in rows if r.mask == TRUE]


@pytest.mark.parametrize(
    "changes",
    [{"alterations": [{"kind": "disable", "instance": "Vase|1"}]}, {"moved": {"Vase|1": {"x": 0.0, "y": 0.5, "z": 2.0}}}],
)
def test_a_visit_with_changes_is_refused(tmp_path, changes):
    scene = TrueScene.load(write_scene(tmp_path))
    with pytest.raises(ValueError, match="something moves in this visit"):
        list(localised(scene, write_visit(tmp_path / "visit", **changes), 90.0, MIN_MASK_PX, None))


def test_a_picture_that_is_gone_is_named(tmp_path):
    scene = TrueScene.load(write_scene(tmp_path))
    directory = write_visit(tmp_path / "untouched")
    (directory / "01_ids.png").unlink()
    with pytest.raises(TourError, match="01_ids.png: No such file or directory; record it again: snakemake"):
        list(localised(scene, directory, 90.0, MIN_MASK_PX, None))
