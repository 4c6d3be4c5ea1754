"""Places of masks in the world, on synthetic depth and on frames of the engine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.perception.backprojection import (
    Camera,
    extents,
    may_show,
    median_point,
    median_points,
    project,
    single_ray_point,
    world_points,
)
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment

SIDE_PX, FIELD_OF_VIEW_DEG = 200, 90.0
SLACK_M = 0.02


@given(yaw=st.floats(0, 360), horizon=st.floats(-80, 80))
def test_the_camera_looks_where_its_angles_say(yaw, horizon):
    axes = Camera((0, 0, 0), yaw, horizon, 90.0).axes()
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0), "right, up, forward as the world's x, y, z"
    right, up, forward = axes.T
    assert right[1] == pytest.approx(0.0), "it does not roll"
    assert forward[1] == pytest.approx(-math.sin(math.radians(horizon)))
    assert up[1] >= 0


def test_the_median_is_on_the_object_where_a_single_ray_misses_it():
    depth = np.full((9, 9), 1.0)
    depth[:, 5:] = 9.0  # a rim that the mask takes from what is far behind
    depth[:, 4] = 5.0
    mask = np.ones((9, 9), bool)
    mask[:, 6:] = False
    camera = Camera((0.0, 0.0, 0.0), 0.0, 0.0, 90.0)
    points = world_points(depth, mask, camera)
    median = median_point(depth, mask, camera)
    assert (points.min(axis=0) <= median).all() and (median <= points.max(axis=0)).all()
    assert median[2] == 1.0
    assert single_ray_point(depth, mask, camera)[0] == pytest.approx((2.5 + 0.5 - 4.5) / 4.5)
    for place in (median_point, single_ray_point):
        with pytest.raises(ValueError, match="empty"):
            place(depth, np.zeros((9, 9), bool), camera)


@pytest.fixture(scope="module")
def simulator() -> Iterator[Any]:
    started = controller.start("embedded", "FloorPlan203", Embodiment(SIDE_PX, SIDE_PX, FIELD_OF_VIEW_DEG, 0.25, 90.0))
    yield started
    started.stop()


@pytest.mark.parametrize(("yaw_deg", "horizon_deg"), [(0.0, 0.0), (90.0, 30.0), (200.0, 0.0), (285.0, 60.0)])
def test_masks_of_a_frame_lie_in_the_boxes_of_their_objects(simulator, yaw_deg, horizon_deg):
    agent = simulator.last_event.metadata["agent"]
    event = simulator.step(
        "TeleportFull", position=agent["position"], rotation={"x": 0, "y": yaw_deg, "z": 0}, horizon=horizon_deg, standing=True
    )
    at = event.metadata["cameraPosition"]
    camera = Camera((at["x"], at["y"], at["z"]), yaw_deg, horizon_deg, FIELD_OF_VIEW_DEG)
    boxes = {o["objectId"]: np.array(o["axisAlignedBoundingBox"]["cornerPoints"]) for o in event.metadata["objects"]}
    seen = [name for name in event.instance_masks if name in boxes and event.instance_masks[name].sum() > 50]
    assert seen
    for name in seen:
        low, high = boxes[name].min(axis=0) - SLACK_M, boxes[name].max(axis=0) + SLACK_M
        points = world_points(event.depth_frame, event.instance_masks[name], camera)
        assert ((points >= low) & (points <= high)).all(axis=1).mean() > 0.99, name
        median = median_point(event.depth_frame, event.instance_masks[name], camera)
        assert ((median >= low) & (median <= high)).all(), name


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 1.0))
def test_an_extent_is_within_that_of_all_points_and_equal_to_it_for_all_of_them(seed, share):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 5, (8, 9))
    masks = rng.random((2, 8, 9)) < 0.5
    masks[:, 0, 0] = True
    camera = Camera(tuple(rng.normal(size=3)), rng.uniform(0, 360), rng.uniform(-30, 60), 90.0)
    for mask, whole, part in zip(masks, *(extents(depth, masks, camera, some) for some in (1.0, share)), strict=True):
        x, y, z = np.ptp(world_points(depth, mask, camera), axis=0)
        assert whole == pytest.approx([max(x, z), min(x, z), y], abs=1e-9)
        assert (part <= whole + 1e-12).all() and part[0] >= part[1] >= 0


def test_pixels_without_depth_do_not_count():
    depth = np.array([[0.0, 2.0, 2.0, 0.0]])
    camera = Camera((0.0, 1.0, 0.0), 0.0, 0.0, 90.0)
    masks = np.array([[[True, True, True, True]], [[True, False, False, True]]])
    whole, none = extents(depth, masks, camera, 1.0)
    assert whole == pytest.approx([4.0, 0.0, 0.0]) and np.isnan(none).all()


@given(seed=st.integers(0, 10**6), yaw=st.floats(0, 360), horizon=st.floats(-60, 60), share=st.floats(0.02, 0.9))
def test_all_medians_at_once_are_those_of_each_mask(seed, yaw, horizon, share):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 9.0, (6, 8)).astype(np.float32)
    masks = rng.random((3, 6, 8)) < share
    masks[2] = False
    camera = Camera((1.0, 0.9, -2.0), yaw, horizon, 75.0)
    found = median_points(depth, masks, camera)
    for place, mask in zip(found, masks, strict=True):
        if mask.any():
            assert place == pytest.approx(median_point(depth, mask, camera), abs=1e-6)
        else:
            assert np.isnan(place).all()


@pytest.mark.parametrize("seed", range(20))
def test_a_frame_that_cannot_show_a_box_shows_none_of_its_points(seed):
    draw = np.random.default_rng(seed)
    points = draw.uniform(-3, 3, 3) + draw.uniform(0, 1.5, 3) * draw.random((200, 3))
    shape = (60, 80)
    cameras = [
        Camera(tuple(draw.uniform(-3, 3, 3)), float(draw.uniform(0, 360)), float(draw.uniform(-60, 60)), 90.0) for _ in range(100)
    ]
    may = may_show(points, [(camera, shape) for camera in cameras])
    for camera, shown in zip(cameras, may.tolist(), strict=True):
        _, rows, columns, _ = project(points, camera, shape, 0.0)
        assert shown or not ((rows >= 0) & (rows <= shape[0]) & (columns >= 0) & (columns <= shape[1])).any()
    assert 0 < np.count_nonzero(may) < len(cameras)
