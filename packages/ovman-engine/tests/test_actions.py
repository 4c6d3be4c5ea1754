"""Actions, tested through the unmodified ai2thor Controller and the engine's own process."""

from __future__ import annotations

import math
import os
import signal

import numpy as np
import pytest

from ovman_engine.client.images import colour
from ovman_engine.plan import floorplan

FIXTURES = ("Floor", "Window", "Painting", "LightSwitch")


def act(controller, action, image=False, **arguments):
    return controller.step(action=action, renderImage=image, **arguments).metadata


def pose(metadata):
    agent = metadata["agent"]
    return (*(agent["position"][k] for k in "xyz"), agent["rotation"]["y"], agent["cameraHorizon"], agent["isStanding"])


def at(controller):
    return pose(controller.last_event.metadata)


def obj(metadata, object_id):
    return next(o for o in metadata["objects"] if o["objectId"] == object_id)


def first(metadata, kind):
    return next(o for o in metadata["objects"] if o["objectType"] == kind)


def flat(point):
    return np.array([point["x"], point["z"]])


# Scenes and pictures


def test_start(controller):
    event = controller.step("Pass")
    assert event.frame.shape == (300, 300, 3) and event.frame.dtype == np.uint8 and event.frame.std() > 5
    assert event.depth_frame.shape == (300, 300) and event.depth_frame.dtype == np.float32
    assert event.metadata["sceneName"] == "FloorPlan201_physics"
    assert (controller.server.camera_near_plane, controller.server.camera_far_plane) == pytest.approx((0.1, 20.0))
    assert controller.scenes_in_build == {*(f"{name}_physics" for name in floorplan.names()), "Procedural"}
    assert at(controller)[:3] == pytest.approx(floorplan.load("FloorPlan201").start, abs=1e-6)


def test_masks_and_depth_agree_with_boxes(controller):
    """Points of a mask, projected back by their depth, lie in the box of the object: rows, columns and signs are right."""
    checked = 0
    for yaw in (0, 90, 210):
        act(controller, "Teleport", rotation=yaw, horizon=30)
        event = controller.step("Pass")
        x, y, z = at(controller)[:3]
        rows, columns = np.mgrid[0:300, 0:300] + 0.5
        right, up = (columns / 150 - 1) * event.depth_frame, (1 - rows / 150) * event.depth_frame
        a, p = math.radians(yaw), math.radians(30)
        axes = np.array(
            [
                [math.cos(a), 0, -math.sin(a)],
                [math.sin(a) * math.sin(p), math.cos(p), math.cos(a) * math.sin(p)],
                [math.sin(a) * math.cos(p), -math.sin(p), math.cos(a) * math.cos(p)],
            ]
        )
        points = np.stack([right, up, event.depth_frame], axis=-1) @ axes + [x, y + 0.675, z]
        for name, mask in event.instance_masks.items():
            record = next((o for o in event.metadata["objects"] if o["objectId"] == name), None)
            if record is None or mask.sum() < 50:
                continue
            corners = np.array(record["axisAlignedBoundingBox"]["cornerPoints"])
            inside = (points[mask] > corners.min(axis=0) - 0.03) & (points[mask] < corners.max(axis=0) + 0.03)
            assert inside.all(axis=1).mean() > 0.97, name
            checked += 1
        assert event.color_to_object_id[colour(name)] == name
        for mask in event.instance_masks.values():
            assert mask.any()
        total = sum(mask.sum() for mask in event.instance_masks.values())
        assert total <= 300 * 300
    assert checked > 8


def test_change_of_resolution(controller):
    event = controller.step("ChangeResolution", x=640, y=480)
    assert (event.screen_width, event.screen_height) == (640, 480)
    assert event.frame.shape == (480, 640, 3) and event.depth_frame.shape == (480, 640)
    assert event.instance_segmentation_frame.shape == (480, 640, 3)
    for x, y in ((0, 100), (100, -1), (100_000, 100)):
        assert not act(controller, "ChangeResolution", x=x, y=y)["lastActionSuccess"]
    assert controller.last_event.screen_width == 640
    assert controller.reset("FloorPlan201", renderImage=True).frame.shape == (300, 300, 3)


def test_no_image_where_none_is_wanted(controller):
    event = controller.step("RotateRight", renderImage=False)
    assert event.frame is None and event.depth_frame is None and event.instance_segmentation_frame is None
    assert controller.step("RotateRight").frame is not None
    controller.reset("FloorPlan201", renderDepthImage=False, renderInstanceSegmentation=False)
    event = controller.step("RotateRight")
    assert event.frame is not None and event.depth_frame is None and event.instance_segmentation_frame is None
    event = controller.step("Pass", renderInstanceSegmentation=True)
    assert event.instance_segmentation_frame is not None and event.depth_frame is None


def test_class_and_normal_images(controller):
    controller.reset("FloorPlan201", renderSemanticSegmentation=True, renderNormalsImage=True)
    event = controller.step("Pass")
    seen = {tuple(c) for c in np.unique(event.semantic_segmentation_frame.reshape(-1, 3), axis=0)}
    types = {o["objectType"] for o in event.metadata["objects"]}
    assert len(seen & {colour(t) for t in types}) > 3
    floor = event.semantic_segmentation_frame[event.instance_masks[first(event.metadata, "Floor")["objectId"]]]
    assert (floor == colour("Floor")).all()
    up = event.normals_frame[event.instance_masks[first(event.metadata, "Floor")["objectId"]]]
    assert up.shape[1] == 3 and np.abs(up[:, 1].astype(int) - 255).max() <= 1
    controller.reset("FloorPlan201", renderSemanticSegmentation=False, renderNormalsImage=False)


def test_a_reset_leaves_nothing_of_what_was_done(controller):
    untouched = act(controller, "Pass")
    chair = first(untouched, "ArmChair")["objectId"]
    act(controller, "DisableObject", objectId=chair)
    act(controller, "MoveAhead")
    act(controller, "PausePhysicsAutoSim")
    other = controller.reset("FloorPlan423").metadata
    assert other["sceneName"] == "FloorPlan423_physics" and chair not in {o["objectId"] for o in other["objects"]}
    assert np.rad2deg(2 * np.arctan(1)) == other["fov"]
    again = controller.reset("FloorPlan201").metadata
    assert again["objects"] == untouched["objects"] and again["agent"] == untouched["agent"]
    assert act(controller, "RotateRight")["agent"]["rotation"]["y"] == 30  # initialisation parameters stay


def test_unknown_scene_and_action(controller):
    with pytest.raises(ValueError, match="not contained in build"):
        controller.reset("FloorPlan999")
    with pytest.raises(ValueError, match="^Invalid action: Dance$"):
        controller.step("Dance")
    with pytest.raises(ValueError, match="missing the following arguments: position,rotation,horizon,standing"):
        controller.step("TeleportFull")
    with pytest.raises(ValueError, match="called with invalid argument: 'haste'"):
        controller.step("MoveAhead", haste=3)
    with pytest.raises(ValueError, match=r"invalid argument: moveMagnitude \(==far\). Cannot convert to: float"):
        controller.step("MoveAhead", moveMagnitude="far")
    assert act(controller, "Pass")["lastActionSuccess"]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"gridSize": 0}, r"grid size must be in the range \(0,5\]"),
        ({"gridSize": 6}, r"grid size must be in the range \(0,5\]"),
        ({"fieldOfView": 180}, r"fov must be set to \(0, 180\)"),
        ({"rotateStepDegrees": 0}, "rotateStepDegrees must be"),
        ({"maxUpwardLookAngle": -1}, "maxUpwardLookAngle must be"),
        ({"agentMode": "arm"}, "Unsupported agent mode: arm"),
        ({"agentMode": None}, "NullReferenceException: Object reference"),
        ({"agentCount": 2}, "Unsupported number of agents: 2"),
        ({"rotateStepDegrees": 30, "snapToGrid": True}, "Invalid values 'rotateStepDegrees'"),
    ],
)
def test_wrong_initialisation(controller, parameters, message):
    with pytest.raises(RuntimeError, match=message):
        controller.step("Initialize", raise_for_failure=True, renderImage=False, **parameters)


# Movement


@pytest.mark.parametrize(("name", "turn"), [("MoveAhead", 0), ("MoveRight", 90), ("MoveBack", 180), ("MoveLeft", 270)])
def test_moves_go_along_the_heading(controller, name, turn):
    moved = 0
    for yaw in range(0, 360, 30):
        act(controller, "Teleport", rotation=yaw)
        before = at(controller)
        metadata = act(controller, name)
        after, heading = at(controller), math.radians(yaw + turn)
        if metadata["lastActionSuccess"]:
            step = (after[0] - before[0], after[2] - before[2])
            assert step == pytest.approx((0.25 * math.sin(heading), 0.25 * math.cos(heading)), abs=1e-9)
            assert after[1] == before[1] and after[3:] == before[3:]
            moved += 1
            act(controller, {0: "MoveBack", 90: "MoveLeft", 180: "MoveAhead", 270: "MoveRight"}[turn])
    assert moved >= 6


def test_length_of_a_move(controller):
    lengths = []
    for arguments in ({"moveMagnitude": 0.1}, {"moveMagnitude": 0}, {"moveMagnitude": -1}, {}):
        before = at(controller)
        act(controller, "MoveAhead", **arguments)
        lengths.append(round(math.dist(before[:3], at(controller)[:3]), 9))
    assert lengths == [0.1, 0, 0, 0.25]
    message = act(controller, "MoveAhead", moveMagnitude=0)["errorMessage"]
    assert message.startswith("InvalidOperationException: moveMagnitude must be > 0. trace: ")


def test_a_blocked_move_says_by_what_and_leaves_the_agent_where_it_was(controller):
    for _ in range(60):
        before = at(controller)
        metadata = act(controller, "MoveAhead")
        if not metadata["lastActionSuccess"]:
            break
    assert metadata["errorMessage"].endswith(" is blocking Agent 0 from moving by (0.0000, 0.0000, 0.2500).")
    assert metadata["errorCode"] is None and at(controller) == before
    assert not act(controller, "MoveAhead", forceAction=True)["lastActionSuccess"] and at(controller) == before
    metadata = act(controller, "MoveAhead", moveMagnitude=100)
    assert metadata["errorMessage"].startswith("Scene bounds do not contain target position: (")


def test_turns(controller):
    yaws = [act(controller, "RotateRight")["agent"]["rotation"]["y"] for _ in range(12)]
    assert yaws == [30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330, 0]
    assert act(controller, "RotateLeft")["agent"]["rotation"]["y"] == 330
    assert act(controller, "RotateLeft", degrees=45.5)["agent"]["rotation"]["y"] == 284.5
    assert act(controller, "RotateRight", degrees=-284.5)["agent"]["rotation"]["y"] == 0
    metadata = act(controller, "RotateLeft", degrees=0)
    assert metadata["errorMessage"].startswith("InvalidOperationException: Cannot rotate by 0 degrees")


def test_the_camera_looks_from_30_degrees_up_to_60_down(controller):
    assert act(controller, "LookUp")["agent"]["cameraHorizon"] == -30
    metadata = act(controller, "LookUp")
    assert metadata["errorMessage"] == "can't look up beyond 30 degrees above the forward horizon"
    assert metadata["errorCode"] == "LookDownCantExceedMin"
    assert [act(controller, "LookDown")["agent"]["cameraHorizon"] for _ in range(3)] == [0, 30, 60]
    metadata = act(controller, "LookDown")
    assert metadata["errorMessage"] == "can't look down beyond 60 degrees below the forward horizon"
    assert (metadata["errorCode"], metadata["agent"]["cameraHorizon"]) == ("LookDownCantExceedMin", 60)
    assert act(controller, "LookUp", degrees=10.5)["agent"]["cameraHorizon"] == 49.5
    assert "requires positive degree value" in act(controller, "LookUp", degrees=-10)["errorMessage"]
    assert "multiple of 0.1" in act(controller, "LookDown", degrees=0.25)["errorMessage"]


def test_teleport_keeps_what_it_is_not_given(controller):
    goal = act(controller, "GetReachablePositions")["actionReturn"][-1]
    act(controller, "Teleport", rotation=123, horizon=30)
    assert at(controller)[3:] == (123, 30, True)
    assert act(controller, "Teleport", position=goal)["lastActionSuccess"]
    assert at(controller) == pytest.approx((goal["x"], goal["y"], goal["z"], 123, 30, True))
    height = act(controller, "Pass")["cameraPosition"]["y"]
    assert act(controller, "Teleport", standing=False)["agent"]["isStanding"] is False
    assert controller.last_event.metadata["cameraPosition"]["y"] == pytest.approx(height - 0.675)
    assert act(controller, "Teleport", **goal, rotation={"x": 0, "y": 30, "z": 0}, standing=True)["lastActionSuccess"]
    assert at(controller) == pytest.approx((goal["x"], goal["y"], goal["z"], 30, 30, True))


def test_teleports_that_are_refused_change_nothing(controller):
    x, y, z, *_ = before = at(controller)
    sofa = first(act(controller, "Pass"), "Sofa")
    inside = {"x": sofa["axisAlignedBoundingBox"]["center"]["x"], "y": y, "z": sofa["axisAlignedBoundingBox"]["center"]["z"]}
    refused = [
        ({"rotation": {"x": 10, "y": 0, "z": 0}}, "can change in pitch or roll"),
        ({"horizon": 61}, "Each horizon must be in [-30:60]. You gave 61."),
        ({"horizon": -31}, "Each horizon must be in [-30:60]. You gave -31."),
        ({"position": {"x": x + 100, "y": y, "z": z}}, "out of scene bounds!"),
        ({"position": {"x": x, "y": y + 0.3, "z": z}}, "too large a change(0.3 > 0.05)"),
        ({"position": inside}, f"Collided with: {sofa['objectId']}."),
    ]
    for arguments, words in refused:
        metadata = act(controller, "Teleport", **arguments)
        assert words in metadata["errorMessage"] and metadata["errorMessage"].count(". trace: ") == 1
        assert metadata["errorCode"] is None and pose(metadata) == before
        full = {"position": {"x": x, "y": y, "z": z}, "rotation": {"x": 0, "y": 0, "z": 0}, "horizon": 0, "standing": True}
        assert words in act(controller, "TeleportFull", **{**full, **arguments})["errorMessage"]
    assert act(controller, "Teleport", position=inside, forceAction=True)["lastActionSuccess"]
    assert at(controller)[:3] == pytest.approx((inside["x"], inside["y"], inside["z"]))
    assert not act(controller, "Teleport", position=5)["lastActionSuccess"]


def test_reachable_positions(controller):
    before = at(controller)
    points = act(controller, "GetReachablePositions")["actionReturn"]
    assert at(controller) == before
    assert np.allclose([points[0][k] for k in "xyz"], before[:3])
    assert len(points) > 100 and len({(p["x"], p["z"]) for p in points}) == len(points)
    lattice = np.array([(p["x"] - before[0], p["z"] - before[2]) for p in points]) / 0.25
    assert np.abs(lattice - lattice.round()).max() < 1e-6 and {p["y"] for p in points} == {before[1]}
    for point in points[:: len(points) // 25]:
        assert act(controller, "Teleport", position=point)["lastActionSuccess"], point
    along = act(controller, "GetReachablePositions", directionsRelativeAgent=True)["actionReturn"]
    act(controller, "RotateRight")
    oblique = act(controller, "GetReachablePositions", directionsRelativeAgent=True)["actionReturn"]
    assert {(p["x"], p["z"]) for p in along} == {(p["x"], p["z"]) for p in points} != {(p["x"], p["z"]) for p in oblique}
    assert "Too many steps" in act(controller, "GetReachablePositions", maxStepCount=1)["errorMessage"]


def test_on_the_grid(controller):
    controller.reset("FloorPlan201", snapToGrid=True, rotateStepDegrees=90)
    x, y, z = at(controller)[:3]
    metadata = act(controller, "Teleport", position={"x": x + 0.1, "y": y, "z": z})
    assert "is not on the grid of size 0.25" in metadata["errorMessage"]
    assert act(controller, "RotateRight")["agent"]["rotation"]["y"] == 90
    act(controller, "MoveAhead", moveMagnitude=0.3)
    assert at(controller)[0] / 0.25 == round(at(controller)[0] / 0.25)


# Objects


def free_spot(controller, clear_m):
    """A reachable point with nothing but floor within `clear_m`, away from the agent."""
    metadata = act(controller, "GetReachablePositions")
    boxes = [
        np.array(o["axisAlignedBoundingBox"]["cornerPoints"])[:, [0, 2]]
        for o in metadata["objects"]
        if o["objectType"] != "Floor"
    ]
    agent = flat(metadata["agent"]["position"])

    def room(point):
        gaps = [np.linalg.norm(np.maximum(np.maximum(b.min(axis=0) - point, point - b.max(axis=0)), 0)) for b in boxes]
        return min([*gaps, np.linalg.norm(point - agent)])

    best = max(metadata["actionReturn"], key=lambda p: room(flat(p)))
    assert room(flat(best)) >= clear_m
    return best


def test_a_placed_object_comes_to_rest_on_what_is_below_and_blocks_the_agent(controller):
    spot = free_spot(controller, 0.7)
    chair = first(act(controller, "Pass"), "Chair")
    metadata = act(controller, "PlaceObjectAtPoint", objectId=chair["objectId"], position={**spot, "y": 1.0})
    assert metadata["lastActionSuccess"], metadata["errorMessage"]
    for _ in range(30):
        metadata = act(controller, "Pass")
        if metadata["isSceneAtRest"]:
            break
    assert metadata["isSceneAtRest"] and not any(o["isMoving"] for o in metadata["objects"])
    placed = obj(metadata, chair["objectId"])
    bottom = np.array(placed["axisAlignedBoundingBox"]["cornerPoints"])[:, 1].min()
    assert bottom == pytest.approx(floorplan.load("FloorPlan201").floor_y, abs=0.03)
    assert np.linalg.norm(flat(placed["position"]) - flat(spot)) < 0.15
    assert (spot["x"], spot["z"]) not in {(p["x"], p["z"]) for p in act(controller, "GetReachablePositions")["actionReturn"]}
    assert "Collided with" in act(controller, "Teleport", position=spot)["errorMessage"]
    event = controller.step("Pass")
    assert len(event.metadata["objects"]) == len(floorplan.load("FloorPlan201").objects)


def test_placements_that_are_refused(controller):
    metadata = act(controller, "Pass")
    chair, sofa = first(metadata, "Chair"), first(metadata, "Sofa")
    before = obj(metadata, chair["objectId"])["position"]
    assert act(controller, "PlaceObjectAtPoint", objectId="Unicorn|1", position=before)["errorMessage"] == (
        "Cannot find object with id Unicorn|1."
    )
    far = {"x": 100, "y": 1, "z": 100}
    metadata = act(controller, "PlaceObjectAtPoint", objectId=chair["objectId"], position=far)
    assert metadata["errorMessage"].startswith("Position coordinate ((100.0, 1.0, 100.0)) is not within scene bounds (Center: ")
    inside = {**sofa["axisAlignedBoundingBox"]["center"], "y": 0.1}
    metadata = act(controller, "TeleportObject", objectId=chair["objectId"], position=inside)
    assert metadata["errorMessage"].startswith(f"{chair['objectId']} is colliding with ")
    assert metadata["errorMessage"].endswith(" after teleport.")
    assert obj(metadata, chair["objectId"])["position"] == before


def test_first_of_several_points_that_is_free(controller):
    chair = first(act(controller, "Pass"), "Chair")
    spot = {**free_spot(controller, 0.7), "y": 1.0}
    points = [{"x": 100, "y": 1, "z": 100}, spot]
    metadata = act(controller, "PlaceObjectAtPoint", objectId=chair["objectId"], positions=points)
    assert metadata["lastActionSuccess"], metadata["errorMessage"]
    assert np.linalg.norm(flat(metadata["actionReturn"]) - flat(spot)) < 0.15


def test_an_object_teleports_exactly(controller):
    spot = {**free_spot(controller, 0.7), "y": 1.2}
    chair = first(act(controller, "Pass"), "Chair")["objectId"]
    metadata = act(controller, "TeleportObject", objectId=chair, position=spot, rotation={"y": 40}, forceKinematic=True)
    assert metadata["lastActionSuccess"], metadata["errorMessage"]
    assert obj(metadata, chair)["position"] == pytest.approx(spot)
    assert obj(metadata, chair)["rotation"] == pytest.approx({"x": 0, "y": 40, "z": 0}, abs=1e-6)
    assert obj(act(controller, "Pass"), chair)["position"] == pytest.approx(spot)


def test_a_disabled_object_is_neither_seen_nor_met(controller):
    chair = next(o for o in act(controller, "Pass")["objects"] if o["objectType"] == "ArmChair")
    centre = chair["axisAlignedBoundingBox"]["center"]
    reachable = [flat(p) for p in act(controller, "GetReachablePositions")["actionReturn"]]
    for point in sorted(reachable, key=lambda p: abs(np.linalg.norm(p - flat(centre)) - 1.2)):
        yaw = math.degrees(math.atan2(centre["x"] - point[0], centre["z"] - point[1]))
        act(controller, "Teleport", position={"x": point[0], "y": at(controller)[1], "z": point[1]}, rotation=yaw, horizon=30)
        if obj(controller.last_event.metadata, chair["objectId"])["visible"]:
            break
    assert chair["objectId"] in controller.step("Pass").instance_masks
    event = controller.step("DisableObject", objectId=chair["objectId"])
    assert event and chair["objectId"] not in event.instance_masks
    assert obj(event.metadata, chair["objectId"])["visible"] is False
    assert act(controller, "DisableObject", objectId=chair["objectId"])["lastActionSuccess"]
    assert len(act(controller, "GetReachablePositions")["actionReturn"]) >= len(reachable)
    event = controller.step("EnableObject", objectId=chair["objectId"])
    assert chair["objectId"] in event.instance_masks
    for action in ("DisableObject", "EnableObject"):
        metadata = act(controller, action, objectId="Unicorn|1")
        assert (metadata["lastActionSuccess"], metadata["errorMessage"]) == (False, "")


def test_removal_lasts_till_reset(controller):
    metadata = act(controller, "Pass")
    chairs = [o["objectId"] for o in metadata["objects"] if o["objectType"] == "Chair"][:2]
    left = act(controller, "RemoveFromScene", objectId=chairs[0])["objects"]
    assert chairs[0] not in {o["objectId"] for o in left} and len(left) == len(metadata["objects"]) - 1
    assert not act(controller, "RemoveFromScene", objectId=chairs[0])["lastActionSuccess"]
    assert act(controller, "RemoveFromScene", objectIds=chairs[1:])["lastActionSuccess"]
    assert chairs[0] not in controller.step("Pass").instance_masks
    assert len(controller.reset("FloorPlan201").metadata["objects"]) == len(metadata["objects"])


def test_a_scene_without_objects(controller):
    """An empty scene can be walked, drawn and simulated."""
    metadata = act(controller, "Pass")
    everything, here = [o["objectId"] for o in metadata["objects"]], metadata["agent"]["position"]
    assert act(controller, "RemoveObjsFromScene", objectIds=everything)["objects"] == []
    for action, arguments in [
        ("RotateRight", {}),
        ("GetReachablePositions", {}),
        ("InitialRandomSpawn", {}),
        ("ToggleMapView", {}),
        ("ToggleMapView", {}),
        ("RandomizeMaterials", {}),
        ("GetShortestPathToPoint", here),
        ("AdvancePhysicsStep", {"allowAutoSimulation": True}),
    ]:
        metadata = act(controller, action, image=True, **arguments)
        assert metadata["lastActionSuccess"], (action, metadata["errorMessage"])
        assert metadata["objects"] == [] and metadata["isSceneAtRest"]
    assert controller.last_event.frame.std() > 1 and controller.last_event.instance_masks


def test_object_poses(controller):
    metadata = act(controller, "Pass")
    movable = [o for o in metadata["objects"] if o["pickupable"] or o["moveable"]]
    chair, vase = first(metadata, "Chair"), first(metadata, "Vase")
    spot = free_spot(controller, 0.7)
    poses = [
        {"objectName": chair["name"], "position": {**spot, "y": chair["position"]["y"]}, "rotation": {"x": 0, "y": 90, "z": 0}},
        {"objectName": vase["name"], "position": vase["position"], "rotation": vase["rotation"]},
        {"objectName": vase["name"], "position": {**vase["position"], "y": 2.0}, "rotation": vase["rotation"]},
    ]
    event = controller.step("SetObjectPoses", objectPoses=poses, placeStationary=True)
    assert event, event.metadata["errorMessage"]
    objects = event.metadata["objects"]
    assert len([o for o in objects if o["pickupable"] or o["moveable"]]) == 3 < len(movable)
    assert {o["objectId"] for o in metadata["objects"] if o["objectType"] in FIXTURES} <= {o["objectId"] for o in objects}
    now = {o["name"]: o for o in objects}
    moved = now[chair["name"]]
    assert moved["position"] == pytest.approx(poses[0]["position"])
    assert moved["objectId"] == f"Chair|{spot['x']:+06.2f}|{chair['position']['y']:+06.2f}|{spot['z']:+06.2f}"
    copy = now[f"{vase['name']}_copy_2"]
    assert copy["objectType"] == "Vase" and copy["position"]["y"] == pytest.approx(2.0)
    assert len({o["objectId"] for o in objects}) == len(objects)
    assert act(controller, "Pass")["objects"] == objects
    metadata = act(controller, "SetObjectPoses", objectPoses=[*poses, {**poses[0], "objectName": "Unicorn"}])
    assert metadata["errorMessage"] == "No Pickupable or Moveable object of name Unicorn found in scene."


def test_only_the_objects_asked_for_are_listed(controller):
    metadata = act(controller, "Pass")
    sofa = first(metadata, "Sofa")
    act(controller, "Teleport", rotation=90)
    whole = act(controller, "RotateRight")["objects"]
    act(controller, "RotateLeft")
    metadata = act(controller, "SetObjectFilter", objectIds=[sofa["objectId"], "Unicorn|1"])
    assert [o["objectId"] for o in metadata["objects"]] == [sofa["objectId"]]
    assert act(controller, "RotateRight")["objects"] == [o for o in whole if o["objectId"] == sofa["objectId"]]
    assert act(controller, "ResetObjectFilter")["objects"] == whole
    act(controller, "SetObjectFilter", objectIds=[])
    assert len(controller.reset("FloorPlan201").metadata["objects"]) == len(whole)


# Physics


def test_time_stands_still_while_paused(controller):
    assert act(controller, "AdvancePhysicsStep")["errorMessage"].startswith(
        "AdvancePhysicsStep can only be called if Physics AutoSimulation is currently paused"
    )
    spot = {**free_spot(controller, 0.7), "y": 1.5}
    chair = first(act(controller, "Pass"), "Chair")["objectId"]
    act(controller, "PausePhysicsAutoSim")
    act(controller, "TeleportObject", objectId=chair, position=spot)
    assert obj(act(controller, "Pass"), chair)["position"]["y"] == pytest.approx(1.5)
    metadata = act(controller, "AdvancePhysicsStep", timeStep=0.05)
    assert obj(metadata, chair)["position"]["y"] < 1.5 and obj(metadata, chair)["isMoving"] and not metadata["isSceneAtRest"]
    assert "timeStep between 0.0f and 0.05f" in act(controller, "AdvancePhysicsStep", timeStep=0.06)["errorMessage"]
    assert "timeStep between 0.0f and 0.05f" in act(controller, "AdvancePhysicsStep", timeStep=0)["errorMessage"]
    assert "simSeconds must be non-negative" in act(controller, "AdvancePhysicsStep", simSeconds=-1)["errorMessage"]
    height = obj(act(controller, "Pass"), chair)["position"]["y"]
    assert obj(act(controller, "UnpausePhysicsAutoSim"), chair)["position"]["y"] < height


def test_actions_without_effect(controller):
    before = act(controller, "Pass")
    for action, arguments in (("Done", {}), ("Pass", {}), ("SetRandomSeed", {"seed": 5}), ("ChangeQuality", {"quality": "Low"})):
        after = act(controller, action, **arguments)
        assert after["lastActionSuccess"] and after["lastAction"] == action
        assert after["objects"] == before["objects"] and pose(after) == pose(before)


# The engine as a process


DROP = ["MoveAhead", "RotateRight", "MoveAhead", "LookDown", "MoveRight"]
REST = ["GetReachablePositions", "RotateLeft", "MoveBack", "Pass", "Pass", "Pass"]


def walk(controller):
    """Events of a walk on which an object is dropped."""
    events = [controller.reset("FloorPlan201")]
    vase = first(events[0].metadata, "Vase")
    above = {**vase["position"], "y": vase["position"]["y"] + 0.3}
    events.append(controller.step("TeleportObject", objectId=vase["objectId"], position=above, forceAction=True))
    return events + [controller.step(action) for action in DROP + REST]


def test_two_engines_at_once_show_the_same_and_fast_emit_changes_nothing(controller, start):
    """Events are equal to the byte, also if one engine sends them all in full and the other sends patches."""
    with start(scene="FloorPlan201", **{**controller.initialization_parameters, "fastActionEmit": False}) as other:
        assert other.unity_pid != controller.unity_pid
        for one, two in zip(walk(controller), walk(other), strict=True):
            for key in one.metadata.keys() - {"colors"}:
                assert one.metadata[key] == two.metadata[key], (one.metadata["lastAction"], key)
            assert (one.frame is None) == (two.frame is None)
            if one.frame is not None:
                assert np.array_equal(one.frame, two.frame) and np.array_equal(one.depth_frame, two.depth_frame)
                assert np.array_equal(one.instance_segmentation_frame, two.instance_segmentation_frame)


def test_an_interrupt_that_is_meant_for_the_client_does_not_end_the_engine(controller, alive):
    os.kill(controller.unity_pid, signal.SIGINT)
    assert act(controller, "Pass")["lastActionSuccess"] and alive(controller.unity_pid)


def test_small_pictures_and_headless(start):
    with start(scene="FloorPlan423", width=120, height=80) as small:
        assert small.last_event.frame.shape == (80, 120, 3)
        start_deg = small.last_event.metadata["agent"]["rotation"]["y"]
        assert small.step("RotateRight").metadata["agent"]["rotation"]["y"] == (start_deg + 90) % 360
    with start(scene="FloorPlan423", headless=True, renderDepthImage=True) as blind:
        assert blind.last_event.frame is None
        event = blind.step("RotateRight")
        assert event and event.frame is None and event.depth_frame is None and len(event.metadata["objects"]) > 10
