"""What the unmodified client does by itself and reads from every event: sizes, numbers, units, and several engines at once."""

from __future__ import annotations

import gc
import json
import weakref

import numpy as np
import pytest
from ai2thor.server import DepthFormat

from ovman_engine import engine
from ovman_engine.picture import camera, scene_mesh


@pytest.fixture(scope="module")
def small(start):
    """A Controller with images below Unity's minimum, and its own clipping planes."""
    options = {"renderDepthImage": True, "cameraNearPlane": 0.3, "cameraFarPlane": 12, "fieldOfView": 60}
    with start(scene="FloorPlan401", width=200, height=150, depth_format=DepthFormat.Normalized, **options) as controller:
        yield controller


def test_small_pictures_and_planes_from_the_start(small):
    event = small.reset("FloorPlan401")
    assert event.frame.shape == (150, 200, 3) and event.depth_frame.shape == (150, 200)
    assert (
        (event.metadata["screenWidth"], event.metadata["screenHeight"]) == (200, 150) == (event.screen_width, event.screen_height)
    )
    assert event.metadata["actionReturn"] == {"cameraNearPlane": pytest.approx(0.3), "cameraFarPlane": 12.0}
    assert (small.server.camera_near_plane, small.server.camera_far_plane) == (pytest.approx(0.3), 12)
    assert event.metadata["fov"] == 60 and event.metadata["depthFormat"] == "Meters"


def test_depth_in_the_units_that_the_client_asks_for(small):
    """Depth in millimetres, and as a fraction of the range between the planes, comes from the same metres."""
    formats = {}
    for wanted in DepthFormat:
        small.server.depth_format = wanted
        formats[wanted] = small.reset("FloorPlan401").depth_frame
    small.server.depth_format = DepthFormat.Normalized
    metres = formats[DepthFormat.Meters]
    assert metres.dtype == np.float32 and 0.3 <= metres.min() < metres.max() < 12
    assert np.allclose(formats[DepthFormat.Millimeters], metres * 1000, rtol=1e-5)
    assert np.allclose(formats[DepthFormat.Normalized], metres / 11.7, rtol=1e-5)


@pytest.mark.soak
def test_resets_let_go_of_worlds_and_keep_a_bounded_number_of_plans():
    """This holds for few plans that repeat as well: what is rebuilt each time must not accumulate."""
    served, worlds, plans = engine.Engine(32, 32), [], []
    for name in ("FloorPlan401", "FloorPlan402", "FloorPlan12", "FloorPlan403", "FloorPlan405", "FloorPlan406") * 2:
        calls = (
            {"action": "Reset", "sceneName": f"{name}_physics"},
            {"action": "Initialize", "renderInstanceSegmentation": True},
            {"action": "AddThirdPartyCamera", "position": {"x": 0, "y": 4, "z": 0}, "rotation": {"x": 90, "y": 0, "z": 0}},
            {"action": "ToggleMapView"},
        )
        for call in calls:
            served.answer(json.dumps(call).encode())
        worlds.append(weakref.ref(served.session.world))
        plans.append(weakref.ref(served.session.world.plan))
    gc.collect()
    assert sum(world() is not None for world in worlds) == 1
    assert len({id(plan()) for plan in plans if plan() is not None}) <= 8
    assert len(camera._plans) <= scene_mesh.PLANS_KEPT and len(scene_mesh._plans) <= scene_mesh.PLANS_KEPT
