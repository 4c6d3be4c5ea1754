"""Contract, section 1: how the engine is started, what it writes to the pipes, and what the client's event contains."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shlex
import signal
from pathlib import Path

import numpy as np
import pytest

from ovman_engine import executable

# fmt: off
METADATA_KEYS = {
    "objects", "isSceneAtRest", "agent", "heldObjectPose", "arm", "fov", "cameraPosition", "cameraOrthSize",
    "thirdPartyCameras", "collided", "collidedObjects", "inventoryObjects", "sceneName", "lastAction", "errorMessage",
    "errorCode", "lastActionSuccess", "screenWidth", "screenHeight", "agentId", "colors", "colorBounds", "flatSurfacesOnGrid",
    "distances", "normals", "isOpenableGrid", "segmentedObjectIds", "objectIdsInBox", "actionIntReturn", "actionFloatReturn",
    "actionStringsReturn", "actionFloatsReturn", "actionVector3sReturn", "visibleRange", "currentTime", "sceneBounds",
    "actionReturn", "depthFormat",
}
# fmt: on
OBJECT_KEYS = 42
INSTANCE, CLASSES, NORMALS = "renderInstanceSegmentation", "renderSemanticSegmentation", "renderNormalsImage"


def test_launch_through_the_client_and_kill(start, tmp_path):
    """Frame size from the command line, the log in its place, clipping planes as set, the first iTHOR scene by default.

    The command is split as by a shell, a wrapper that execs the engine works as well, and the client notices an engine's death.
    """
    script = tmp_path / "an engine.sh"
    script.write_text(f'#!/bin/sh\nexec {executable()} "$@"\n')
    script.chmod(0o755)
    options = {"local_executable_path": shlex.quote(str(script)), "server_timeout": None, "width": 320, "height": 310}
    with start(cameraFarPlane=30.0, **options) as controller:
        assert controller.last_event.frame.shape == (310, 320, 3)
        assert controller.scene == "FloorPlan10_physics" == controller.last_event.metadata["sceneName"]
        assert (controller.server.camera_near_plane, controller.server.camera_far_plane) == pytest.approx((0.1, 30.0))
        assert {f"FloorPlan{n}_physics" for r in (1, 201, 301, 401) for n in range(r, r + 30)} <= controller.scenes_in_build
        assert Path("~/.ai2thor/log/unity.log").expanduser().exists()
        os.kill(controller.unity_pid, signal.SIGKILL)
        os.waitid(os.P_PID, controller.unity_pid, os.WEXITED | os.WNOWAIT)
        with pytest.raises((RuntimeError, BrokenPipeError)):
            controller.step("Pass")


def test_headless_sends_no_images(start):
    with start(scene="FloorPlan403", headless=True, renderDepthImage=True, renderInstanceSegmentation=True) as controller:
        event = controller.step("RotateRight")
        assert event and event.frame is None and event.depth_frame is None and event.instance_segmentation_frame is None
        assert event.metadata["objects"] and controller.step("GetReachablePositions").metadata["actionReturn"]


def test_images_on_demand(thor):
    """The client also copies deprecated names."""
    thor.reset(renderDepthImage=False, renderInstanceSegmentation=False)
    event = thor.controller.step("Pass")
    assert event.frame is not None and event.depth_frame is None and event.instance_segmentation_frame is None
    assert thor.controller.step("Pass", renderObjectImage=True).instance_segmentation_frame is not None
    assert thor.controller.step("RotateRight", renderClassImage=True).semantic_segmentation_frame is not None
    assert thor.controller.step("RotateRight", renderInstanceSegmentation=True).instance_masks
    assert thor.controller.step("RotateRight", renderNormalsImage=True).normals_frame.shape == (150, 200, 3)
    thor.reset(renderObjectImage=True, renderClassImage=True, renderInstanceSegmentation=False)
    event = thor.controller.step("Pass")
    assert event.instance_segmentation_frame is not None and event.semantic_segmentation_frame is not None


def test_metadata_keys(thor):
    metadata = thor.look().metadata
    assert not METADATA_KEYS - set(dict.keys(metadata))
    agent = metadata["agent"]
    assert {"name", "position", "rotation", "cameraHorizon", "isStanding", "inHighFrictionArea"} <= set(agent)
    assert {"position", "rotation", "localPosition", "localRotation"} <= set(metadata["heldObjectPose"])
    assert metadata["errorMessage"] == "" and metadata["errorCode"] in (None, "") and metadata["cameraOrthSize"] == -1
    bounds = metadata["sceneBounds"]
    assert set(bounds) == {"center", "size", "cornerPoints"} and len(bounds["cornerPoints"]) == 8
    corners = np.array([list(c.values()) if isinstance(c, dict) else c for c in bounds["cornerPoints"]])
    size = [bounds["size"][k] for k in "xyz"]
    assert np.allclose(np.ptp(corners, axis=0), size, atol=1e-4)
    for record in metadata["objects"]:
        keys = set(record) - {"visibleBounds2D"}
        assert len(keys) == OBJECT_KEYS, sorted(keys)
        json.dumps(record, allow_nan=False)


def test_images_are_the_right_way_up_and_round(thor):
    """The depth of a mask, projected back by the contract's camera, lies in the object's box: rows, columns, signs and scale are
    right.
    """
    thor.reset(snapToGrid=False)
    checked = 0
    for _ in range(6):
        event = thor.look(position=thor.free_cell(), rotation=thor.random.uniform(0, 360), horizon=20, standing=True)
        assert event.frame.dtype == np.uint8 and event.frame.shape == (150, 200, 3)
        assert event.depth_frame.dtype == np.float32 and event.depth_frame.shape == (150, 200)
        assert event.metadata["depthFormat"] == "Meters"
        yaw, pitch = (
            math.radians(event.metadata["agent"][k]["y"] if k == "rotation" else event.metadata["agent"][k])
            for k in ("rotation", "cameraHorizon")
        )
        forward = np.array([math.sin(yaw) * math.cos(pitch), -math.sin(pitch), math.cos(yaw) * math.cos(pitch)])
        right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
        up = np.cross(forward, right)
        eye = np.array([event.metadata["cameraPosition"][k] for k in "xyz"])
        rows, columns = np.mgrid[0:150, 0:200]
        half = math.tan(math.radians(event.metadata["fov"]) / 2)
        across, above = ((columns + 0.5) / 100 - 1) * half * 200 / 150, (1 - (rows + 0.5) / 75) * half
        rays = forward + across[..., None] * right + above[..., None] * up
        points = eye + event.depth_frame[..., None] * rays
        for object_id, mask in event.instance_masks.items():
            record = event.get_object(object_id)
            if record is None or mask.sum() < 60:
                continue
            box = record["axisAlignedBoundingBox"]
            centre, size = (np.array([box[k][a] for a in "xyz"]) for k in ("center", "size"))
            out = np.abs(points[mask] - centre) > size / 2 + 0.03
            assert out.any(axis=1).mean() < 0.1, object_id
            checked += 1
    assert checked >= 5


def test_colours_name_instances_and_classes(thor):
    """MD5 of the id or type gives the colour; masks are found by it, classes too."""
    thor.reset(renderSemanticSegmentation=True)
    event = thor.look(position=thor.free_cell(), rotation=0, horizon=30, standing=True)
    names = {c["name"]: tuple(c["color"]) for c in event.metadata["colors"]}
    assert set(thor.objects) <= set(names)
    assert {o["objectType"] for o in thor.metadata["objects"]} <= set(names)
    for name in (*thor.objects, *(o["objectType"] for o in thor.metadata["objects"])):
        assert names[name] == tuple(hashlib.md5(name.encode()).digest()[:3]), name
    shown = {tuple(c) for c in event.instance_segmentation_frame.reshape(-1, 3).tolist()}
    assert shown & {names[i] for i in thor.objects}
    for object_id in list(event.instance_masks)[:8]:
        mask = event.instance_masks[object_id]
        assert (event.instance_segmentation_frame[mask] == names[object_id]).all()
    classes = {tuple(c) for c in event.semantic_segmentation_frame.reshape(-1, 3).tolist()}
    assert classes & {names[o["objectType"]] for o in thor.metadata["objects"]}
    assert any("|" not in name for name in event.class_masks if name in names) or not len(event.class_masks)


def test_codes_become_value_errors_and_the_rest_falsy_events(thor):
    before = thor.pose
    for name, arguments in (
        ("Nothing", {}),
        ("MoveAhead", {"zzz": 1}),
        ("TeleportFull", {}),
        ("MoveAhead", {"moveMagnitude": []}),
    ):
        with pytest.raises(ValueError):
            thor.step(name, **arguments)
    assert thor.pose == before
    for name in ("LookDown", "LookUp", "Initialize"):  # actions of the old style take anything
        thor.ok(name, zzz=1)
    event = thor.step("RemoveFromScene", objectId="Nothing|+00.00|+00.00|+00.00")
    assert not event and event.metadata["errorCode"] not in ("InvalidAction", "MissingArguments", "InvalidArgument")
    thor.ok("Pass")
