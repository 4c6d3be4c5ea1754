"""Third-party cameras and the map view: what the client receives, and what they show."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.picture.camera import View
from ovman_engine.picture.third_party import normal_angles
from ovman_engine.plan.floorplan import rotation_matrix

KINDS = {"renderDepthImage": True, "renderInstanceSegmentation": True}
ALL_KINDS = {**KINDS, "renderSemanticSegmentation": True, "renderNormalsImage": True}
HERE = {"position": {"x": -2.0, "y": 1.5, "z": 3.0}, "rotation": {"x": 20.0, "y": 200.0, "z": 0.0}}


@pytest.fixture
def scene(reset):
    """A Controller with small images on the untouched scene."""
    return reset("FloorPlan201", width=120, height=90, **KINDS)


def added(controller, **arguments):
    return controller.step("AddThirdPartyCamera", raise_for_failure=True, **{**HERE, **arguments})


def shares(image, other, slack=0.0):
    """Fraction of equal pixels of two images."""
    return float((np.abs(image.astype(float) - other).reshape(image.shape[0] * image.shape[1], -1).max(axis=1) <= slack).mean())


def test_every_kind_of_image_of_every_camera_in_order(reset):
    home = reset("FloorPlan201", width=120, height=90, **ALL_KINDS)
    assert home.last_event.third_party_camera_frames == [] and home.last_event.metadata["thirdPartyCameras"] == []
    added(home)
    event = added(home, rotation={"x": 0, "y": 20, "z": 0}, fieldOfView=60)
    lists = (
        event.third_party_camera_frames,
        event.third_party_depth_frames,
        event.third_party_normals_frames,
        event.third_party_instance_segmentation_frames,
        event.third_party_semantic_segmentation_frames,
    )
    shapes = [(90, 120, 3), (90, 120), (90, 120, 3), (90, 120, 3), (90, 120, 3)]
    for images, shape in zip(lists, shapes, strict=True):
        assert [i.shape for i in images] == [shape] * 2
        assert not np.array_equal(images[0], images[1])
    assert lists[1][0].dtype == np.float32 and event.frame.shape == (90, 120, 3)
    first, second = event.metadata["thirdPartyCameras"]
    assert first == {"thirdPartyCameraId": 0, **HERE, "fieldOfView": 90.0}
    assert second["thirdPartyCameraId"] == 1 and second["fieldOfView"] == 60.0 and second["rotation"]["y"] == 20
    floor = next(o["objectId"] for o in event.metadata["objects"] if o["objectType"] == "Floor")
    mask = event.third_party_instance_masks[0][floor]
    assert (event.third_party_semantic_segmentation_frames[0][mask] == event.object_id_to_color["Floor"]).all()
    assert event.third_party_class_masks[0]["Floor"].sum() >= mask.sum() > 100
    assert home.reset("FloorPlan201").third_party_camera_frames == []
    assert home.last_event.metadata["thirdPartyCameras"] == []


def test_a_camera_at_the_place_of_the_eye_sees_what_the_agent_saw(scene):
    cells = scene.step("GetReachablePositions").metadata["actionReturn"]
    before = scene.last_event
    eye, agent = before.metadata["cameraPosition"], before.metadata["agent"]
    behind = min(cells, key=lambda c: c["z"])
    assert agent["rotation"]["y"] == 0 and behind["z"] < eye["z"] - 0.5
    scene.step("Teleport", position=behind, raise_for_failure=True)
    event = added(scene, position=eye, rotation={"x": agent["cameraHorizon"], "y": agent["rotation"]["y"], "z": 0})
    assert shares(event.third_party_depth_frames[0], before.depth_frame, 1e-4) > 0.995
    assert shares(event.third_party_instance_segmentation_frames[0], before.instance_segmentation_frame) > 0.995
    assert shares(event.third_party_camera_frames[0], before.frame, 8) > 0.9
    event = scene.step("ChangeResolution", x=100, y=100, raise_for_failure=True)
    assert event.third_party_camera_frames[0].shape == (100, 100, 3)
    scene.step("ChangeResolution", x=120, y=90, raise_for_failure=True)


@given(st.tuples(*[st.floats(-720, 720)] * 3))
def test_angles_are_reported_in_one_way(euler):
    normal = np.array(normal_angles(np.array(euler)))
    assert (normal >= 0).all() and (normal < 360).all() and (normal[0] <= 90 or normal[0] >= 270)
    assert np.allclose(rotation_matrix(normal), rotation_matrix(np.array(euler)), atol=1e-4)
    pitch, yaw, roll = normal
    right, up, forward = View(np.zeros(3), yaw, pitch, roll_deg=roll).axes()
    assert np.allclose(np.stack([right, up, forward], axis=1), rotation_matrix(normal))
    assert np.allclose(np.cross(forward, right), -up) or np.allclose(np.cross(up, forward), right)


def test_an_update_changes_what_it_names_and_nothing_else(scene):
    added(scene, fieldOfView=70, skyboxColor="red")
    other = added(scene, rotation=30).metadata["thirdPartyCameras"][1]
    assert other["rotation"] == {"x": 0.0, "y": 30.0, "z": 0.0}
    frames = scene.step("Pass").third_party_camera_frames
    event = scene.step("UpdateThirdPartyCamera", position={"y": 1.75}, rotation={"x": 10})
    now = event.metadata["thirdPartyCameras"]
    assert now[0] == {
        "thirdPartyCameraId": 0,
        "position": {**HERE["position"], "y": 1.75},
        "rotation": {**HERE["rotation"], "x": 10.0},
        "fieldOfView": 70.0,
    }
    assert now[1] == other and np.array_equal(event.third_party_camera_frames[1], frames[1])
    assert not np.array_equal(event.third_party_camera_frames[0], frames[0])
    event = scene.step("UpdateThirdPartyCamera", thirdPartyCameraId=1, fieldOfView=40)
    assert [c["fieldOfView"] for c in event.metadata["thirdPartyCameras"]] == [70, 40]
    event = scene.step("UpdateThirdPartyCamera", thirdPartyCameraId=1, fieldOfView=90)
    assert np.array_equal(event.third_party_camera_frames[1], frames[1])


@pytest.mark.parametrize(
    ("action", "arguments", "words"),
    [
        ("AddThirdPartyCamera", {"fieldOfView": 0}, "fieldOfView: 0 must be in"),
        ("AddThirdPartyCamera", {"fieldOfView": -5}, "ArgumentOutOfRangeException"),
        ("AddThirdPartyCamera", {"nearClippingPlane": 2, "farClippingPlane": 1}, "0 < near < far"),
        ("AddThirdPartyCamera", {"orthographicSize": 2}, "can only be set when orthographic=True"),
        ("AddThirdPartyCamera", {"orthographic": True, "orthographicSize": -1}, "orthographicSize"),
        ("AddThirdPartyCamera", {"skyboxColor": "no colour"}, "Invalid skyboxColor: no colour!"),
        ("UpdateThirdPartyCamera", {"thirdPartyCameraId": 1}, "thirdPartyCameraId: 1"),
        ("UpdateThirdPartyCamera", {"fieldOfView": 180}, "fieldOfView: 180 must be in"),
        ("UpdateThirdPartyCamera", {"farClippingPlane": 0.01}, "0 < near < far"),
    ],
)
def test_what_is_no_camera_is_refused_and_changes_nothing(scene, action, arguments, words):
    before = added(scene)
    event = scene.step(action, **(HERE if action.startswith("Add") else {}), **arguments)
    assert not event and words in event.metadata["errorMessage"] and event.metadata["errorCode"] is None
    assert event.metadata["thirdPartyCameras"] == before.metadata["thirdPartyCameras"]
    assert np.array_equal(event.third_party_camera_frames[0], before.third_party_camera_frames[0])


@pytest.mark.parametrize(
    ("text", "colour"),
    [("Orange", (255, 165, 0)), ("#0a141e", (10, 20, 30)), ("#fA0", (255, 170, 0)), ("#01020304", (1, 2, 3))],
)  # fmt: skip
def test_the_sky_has_the_colour_that_was_asked_for(scene, text, colour):
    up = {"position": {"x": 40.0, "y": 1.0, "z": 0.0}, "rotation": {"x": -80.0, "y": 0.0, "z": 0.0}}
    default = added(scene, **up).third_party_camera_frames[0]
    event = scene.step("UpdateThirdPartyCamera", skyboxColor=text)
    assert (event.third_party_camera_frames[0] == colour).all() and (event.third_party_depth_frames[0] == 20).all()
    assert not event.third_party_instance_segmentation_frames[0].any()
    assert np.array_equal(scene.step("Pass").third_party_camera_frames[0], event.third_party_camera_frames[0])
    assert np.array_equal(scene.step("UpdateThirdPartyCamera", skyboxColor="default").third_party_camera_frames[0], default)


def test_a_picture_without_perspective_has_planar_depth(scene):
    height = 2.2
    pose = {"position": {"x": -2.5, "y": height, "z": 3.0}, "rotation": {"x": 90, "y": 0, "z": 0}}
    event = added(scene, **pose, orthographic=True, orthographicSize=1.5)
    floor = next(o for o in event.metadata["objects"] if o["objectType"] == "Floor")
    mask, depth = event.third_party_instance_masks[0][floor["objectId"]], event.third_party_depth_frames[0]
    assert mask.sum() > 200 and np.ptp(depth[mask]) < 1e-3
    rows, columns = np.nonzero(np.ones_like(mask))
    pixel = 2 * 1.5 / 90
    x, z = -2.5 + (columns + 0.5 - 60) * pixel, 3.0 - (rows + 0.5 - 45) * pixel
    for obj in event.metadata["objects"]:
        seen = event.third_party_instance_masks[0].mask(obj["objectId"])
        if seen is None or obj["axisAlignedBoundingBox"] is None:
            continue
        corners = np.array(obj["axisAlignedBoundingBox"]["cornerPoints"])
        low, high = corners.min(axis=0), corners.max(axis=0)
        inside = seen.ravel()
        top = height - depth.ravel()[inside]
        assert (x[inside] > low[0] - 0.02).all() and (x[inside] < high[0] + 0.02).all(), obj["name"]
        assert (z[inside] > low[2] - 0.02).all() and (z[inside] < high[2] + 0.02).all(), obj["name"]
        assert (top < high[1] + 0.02).all() and (top > low[1] - 0.02).all(), obj["name"]
    perspective = scene.step("UpdateThirdPartyCamera", orthographic=False)
    assert not np.array_equal(perspective.third_party_depth_frames[0], depth)
    again = scene.step("UpdateThirdPartyCamera", orthographic=True)
    assert np.array_equal(again.third_party_depth_frames[0], depth)


@pytest.mark.parametrize("name", ["FloorPlan201", "FloorPlan410"])
def test_the_map_view_shows_the_whole_room_and_goes_as_it_came(scene, name):
    before = scene.reset(name)
    event = scene.step("ToggleMapView", raise_for_failure=True)
    size, bounds = event.metadata["cameraOrthSize"], event.metadata["sceneBounds"]
    assert size == pytest.approx(max(bounds["size"]["x"], bounds["size"]["z"]) / 2)
    assert event.metadata["agent"] == before.metadata["agent"] and before.metadata["cameraOrthSize"] == -1
    wall_high = [
        o for o in event.metadata["objects"] if o["objectType"] in ("Floor", "Sofa", "Bed", "Toilet", "Fridge", "DiningTable")
    ]
    assert len(wall_high) >= 2
    for obj in wall_high:
        assert event.instance_masks.mask(obj["objectId"]) is not None, obj["name"]
    ceiling = [n for n in event.object_id_to_color if n.startswith("ceiling|")]
    assert len(ceiling) >= 2 and not any(event.instance_masks.mask(n) is not None for n in ceiling), "nor are its lamps seen"
    walls = [n for n in event.object_id_to_color if n.startswith("wall|") and event.instance_masks.mask(n) is not None]
    assert len(walls) >= 3
    body = (event.instance_segmentation_frame == 0).all(axis=2) & (event.depth_frame < 15)
    x, z = (event.metadata["agent"]["position"][k] - bounds["center"][k] for k in "xz")
    assert body[int(45 - z * 45 / size), int(60 + x * 45 / size)]
    properties = scene.step("GetMapViewCameraProperties").metadata["actionReturn"]
    assert set(properties) == {"position", "rotation", "orthographicSize", "orthographic"}
    assert properties["orthographic"] is True and properties["rotation"] == {"x": 90.0, "y": 0.0, "z": 0.0}
    assert properties["orthographicSize"] == size and event.metadata["cameraPosition"] == properties["position"]
    after = scene.step("ToggleMapView", raise_for_failure=True)
    assert after.metadata["cameraOrthSize"] == -1 and after.metadata["cameraPosition"] == before.metadata["cameraPosition"]
    assert np.array_equal(after.frame, before.frame) and np.array_equal(after.depth_frame, before.depth_frame)
    twin = scene.step("AddThirdPartyCamera", **properties, raise_for_failure=True)
    assert np.array_equal(twin.third_party_camera_frames[0], event.frame)
    scene.step("ToggleMapView")
    assert scene.reset("FloorPlan201").metadata["cameraOrthSize"] == -1
