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
from ovman_engine.plan import floorplan


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


def test_a_size_given_to_reset_stays(small):
    assert small.reset("FloorPlan402", width=90, height=310).frame.shape == (310, 90, 3)
    assert small.reset("FloorPlan401").frame.shape == (310, 90, 3)
    assert small.reset("FloorPlan401", width=200, height=150).metadata["screenWidth"] == 200


@pytest.mark.parametrize("number", [5, 0, -3, 2**31, 2**63 - 1, 1.5, "abc", None, True])
def test_sequence_numbers_are_echoed_and_counted_on(small, number):
    event = small.step({"action": "Pass", "sequenceId": number})
    assert event and small.server.sequence_id == number
    small.server.sequence_id = 41
    assert small.step("RotateRight") and small.server.sequence_id == 42


def test_time_counts_from_each_reset(small):
    times = [small.step("Pass").metadata["currentTime"] for _ in range(3)]
    assert times == sorted(set(times))
    assert small.reset("FloorPlan401").metadata["currentTime"] < times[1]


def test_flow_is_accepted_and_not_drawn(small):
    event = small.reset("FloorPlan401", renderFlowImage=True)
    assert event and event.frame is not None and not hasattr(event, "flows_frame") and event.third_party_flows_frames == []
    small.reset("FloorPlan401", renderFlowImage=False)


def test_headless_sends_no_image_whatever_is_asked_for(start):
    with start(scene="FloorPlan401", headless=True, renderDepthImage=True, renderInstanceSegmentation=True) as controller:
        pose = {"position": {"x": 0, "y": 1, "z": 0}, "rotation": {"x": 0, "y": 0, "z": 0}}
        calls = (("AddThirdPartyCamera", pose), ("ToggleMapView", {}), ("Pass", {"renderImage": True}))
        for action, arguments in calls:
            event = controller.step(action, **arguments)
            assert event and event.frame is None and event.depth_frame is None and event.third_party_camera_frames == []
            assert event.metadata["colors"] is None and event.metadata["objects"]
        assert len(event.metadata["thirdPartyCameras"]) == 1 and event.metadata["cameraOrthSize"] > 0
        assert controller.step("GetReachablePositions").metadata["actionReturn"]


def test_without_a_scene_it_begins_with_the_first_one(start):
    with start() as controller:
        names = sorted(f"{name}_physics" for name in floorplan.names())
        assert controller.scenes_in_build == {*names, "Procedural"}
        assert controller.last_event.metadata["sceneName"] == controller.scene == names[0]
        assert controller.last_event.frame.shape == (300, 300, 3)


def test_two_engines_beside_each_other_do_not_touch(start, small):
    alone = small.reset("FloorPlan401")
    with start(scene="FloorPlan402", width=100, height=100) as other:
        assert other.unity_pid != small.unity_pid
        for _ in range(3):
            turned, passed = other.step("RotateRight"), small.step("Pass")
            assert np.array_equal(passed.frame, alone.frame) and turned.metadata["sceneName"] == "FloorPlan402_physics"
            assert passed.metadata["agent"] == alone.metadata["agent"] != turned.metadata["agent"]
    assert np.array_equal(small.step("Pass").frame, alone.frame)


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
