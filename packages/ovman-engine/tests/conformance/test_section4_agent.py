"""Contract, section 4: initialisation, moves, turns, looks and paths of the agent."""

from __future__ import annotations

import numpy as np
import pytest

from conformance.conftest import heading, xyz

FAR = {"x": 60.0, "y": 0.9, "z": 60.0}


# Initialize


@pytest.mark.contract("4 Initialize")
def test_initialize_returns_the_planes_and_snaps(thor):
    returned = thor.ok("Initialize", gridSize=0.25).metadata["actionReturn"]
    assert returned["cameraNearPlane"] == pytest.approx(0.1) and returned["cameraFarPlane"] == pytest.approx(20)
    assert np.allclose(thor.position[[0, 2]] / 0.25, np.round(thor.position[[0, 2]] / 0.25), atol=1e-3)


@pytest.mark.contract("4 Initialize")
@pytest.mark.parametrize("fov", [0, -10, 180, 200])
@pytest.mark.scenes(1)
def test_initialize_refuses_fields_of_view(thor, fov):
    thor.refused("Initialize", "fov must be set to (0, 180)", gridSize=0.25, fieldOfView=fov)


@pytest.mark.contract("4 Initialize")
@pytest.mark.parametrize("grid", [-1, 0, 5.1, 100])
@pytest.mark.scenes(1)
def test_initialize_refuses_grids(thor, grid):
    thor.refused("Initialize", "grid size must be in the range (0,5]", gridSize=grid)


@pytest.mark.contract("4 Initialize")
@pytest.mark.parametrize("degrees", [-30, 0])
@pytest.mark.scenes(1)
def test_initialize_refuses_rotation_steps(thor, degrees):
    thor.refused("Initialize", "rotateStepDegrees must be", gridSize=0.25, rotateStepDegrees=degrees)


@pytest.mark.contract("4 Initialize")
def test_initialize_refuses_thirty_degrees_on_the_grid(thor):
    thor.refused("Initialize", "Invalid values 'rotateStepDegrees'", rotateStepDegrees=30, snapToGrid=True)
    thor.ok("Initialize", rotateStepDegrees=30, snapToGrid=False)
    before = thor.yaw
    thor.ok("RotateRight")
    assert (thor.yaw - before) % 360 == pytest.approx(30, abs=1e-2)


@pytest.mark.contract("4 Initialize")
@pytest.mark.parametrize("fov", [45.0, 79.0, 120.0])
def test_initialize_sets_the_field_of_view(thor, fov):
    thor.reset(fieldOfView=fov)
    assert thor.metadata["fov"] == pytest.approx(fov)


@pytest.mark.contract("4 Initialize")
def test_initialize_sets_the_grid_and_the_turn(thor):
    thor.reset(gridSize=0.5, rotateStepDegrees=180)
    before = thor.yaw
    thor.ok("RotateLeft")
    assert abs(thor.yaw - before) % 360 == pytest.approx(180, abs=1e-2)
    for yaw in (0, 90, 180, 270):
        thor.ok("Teleport", rotation=yaw)
        start = thor.position
        if thor.step("MoveAhead"):
            assert np.linalg.norm(thor.position - start) == pytest.approx(0.5, abs=1e-3)
            return
    pytest.skip("nowhere to go by half a metre")


@pytest.mark.contract("4 Initialize")
def test_initialize_turns_images_on_and_off(thor):
    for on in (True, False):
        flags = ("renderDepthImage", "renderInstanceSegmentation", "renderSemanticSegmentation", "renderNormalsImage")
        thor.reset(**dict.fromkeys(flags, on))
        event = thor.look()
        images = (event.depth_frame, event.instance_segmentation_frame, event.semantic_segmentation_frame, event.normals_frame)
        assert all((image is not None) is on for image in images) and event.frame is not None
    thor.reset(renderNormalsImage=True)
    normals = thor.look().normals_frame
    assert normals.shape == (150, 200, 3) and normals.dtype == np.uint8 and normals.std() > 1


@pytest.mark.contract("4 Initialize", "4 LookUp", "4 LookDown")
def test_initialize_sets_the_limits_of_looking(thor):
    thor.reset(maxUpwardLookAngle=10, maxDownwardLookAngle=15)
    thor.refused("LookDown", "can't look down beyond")
    thor.refused("LookUp", "can't look up beyond")
    thor.ok("LookDown", degrees=15)
    assert thor.agent["cameraHorizon"] == pytest.approx(15, abs=1e-2)


# Moves


@pytest.mark.contract("4 MoveAhead", "4 MoveBack", "4 MoveLeft", "4 MoveRight")
@pytest.mark.parametrize(("action", "turn"), [("MoveAhead", 0), ("MoveRight", 90), ("MoveBack", 180), ("MoveLeft", 270)])
def test_move(thor, action, turn):
    """A move has the grid's spacing or the requested length; the reverse move leads back."""
    thor.reset(snapToGrid=False)
    opposite = {"MoveAhead": "MoveBack", "MoveBack": "MoveAhead", "MoveLeft": "MoveRight", "MoveRight": "MoveLeft"}[action]
    done = 0
    for cell in thor.random.sample(thor.reachable(), 10):
        thor.go(cell, thor.random.choice([0, 90, 180, 270]))
        start = thor.position
        for arguments, length in (({}, 0.25), ({"moveMagnitude": 0.1}, 0.1)):
            if thor.step(action, **arguments):
                assert np.allclose(thor.position - start, length * heading(thor.yaw + turn), atol=1e-3)
                thor.ok(opposite, **arguments)
                assert np.allclose(thor.position, start, atol=1e-3)
                done += 1
    assert done


@pytest.mark.contract("4 MoveAhead")
@pytest.mark.scenes(4)
def test_blocked_move(thor):
    """A walk ends at a named obstacle or at the end of the scene; the pose stays, and the next turn works."""
    for yaw in (0, 90, 180, 270):
        thor.ok("Teleport", rotation=yaw)
        for _ in range(60):
            before = thor.pose
            event = thor.step("MoveAhead")
            if not event:
                break
        assert not event and thor.pose == before
        message = event.metadata["errorMessage"]
        assert "is blocking Agent 0 from moving by (" in message or message.startswith(
            "Scene bounds do not contain target position"
        )
        if "is blocking" in message:
            assert "|" in message or message.split()[0]
        thor.ok("RotateRight")


@pytest.mark.contract("4 MoveAhead")
@pytest.mark.scenes(1)
def test_blocked_by_what_was_put_there(thor):
    """The name of the obstacle is in the message."""
    cells = {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}
    cell = thor.random.choice(
        sorted(
            c
            for c in cells
            if (round(c[0], 2), round(c[1] + 0.25, 2)) in cells and (round(c[0], 2), round(c[1] + 0.5, 2)) in cells
        )
    )
    thor.go({"x": cell[0], "y": thor.position[1], "z": cell[1]}, 0)
    slim = [o for o in thor.movables() if max(o["axisAlignedBoundingBox"]["size"][a] for a in "xz") < 0.4]
    record = max(slim, key=lambda o: o["axisAlignedBoundingBox"]["size"]["y"])
    spot = {"x": cell[0], "y": thor.position[1], "z": cell[1] + 0.55}
    thor.ok(
        "TeleportObject",
        objectId=record["objectId"],
        position=spot,
        rotation=record["rotation"],
        forceAction=True,
        forceKinematic=True,
    )
    event = thor.refused("MoveAhead", "is blocking Agent 0 from moving by (", moveMagnitude=0.5)
    assert record["objectId"] in event.metadata["errorMessage"] or record["name"] in event.metadata["errorMessage"]


# Turns


@pytest.mark.contract("4 RotateLeft", "4 RotateRight")
def test_turn(thor):
    start = thor.pose
    for action, sign in (("RotateRight", 1), ("RotateLeft", -1)):
        before = thor.yaw
        thor.ok(action)
        assert (thor.yaw - before) % 360 == pytest.approx(sign * 90 % 360, abs=1e-2)
    assert thor.pose == pytest.approx(start, abs=1e-2)
    thor.reset(snapToGrid=False)
    for degrees in (1.5, 45, 137):
        before = thor.yaw
        thor.ok("RotateRight", degrees=degrees)
        assert (thor.yaw - before) % 360 == pytest.approx(degrees, abs=1e-2)
        thor.ok("RotateLeft", degrees=degrees)
        assert (thor.yaw - before + 180) % 360 == pytest.approx(180, abs=1e-2)


@pytest.mark.contract("4 RotateLeft", "4 RotateRight")
@pytest.mark.parametrize("action", ["RotateLeft", "RotateRight"])
def test_turn_by_nothing(thor, action):
    thor.refused(action, "InvalidOperationException: Cannot rotate by 0 degrees", degrees=0)


# Looking


@pytest.mark.contract("4 LookUp", "4 LookDown")
def test_look(thor):
    thor.ok("Teleport", horizon=0)
    for action, horizons in (("LookDown", (30, 60)), ("LookUp", (30, 0, -30))):
        for horizon in horizons:
            thor.ok(action)
            assert thor.agent["cameraHorizon"] == pytest.approx(horizon, abs=0.01)
    event = thor.refused("LookUp", "can't look up beyond 30 degrees above the forward horizon")
    assert event.metadata["errorCode"] == "LookDownCantExceedMin"  # AI2-THOR has one code for both limits
    thor.ok("Teleport", horizon=60)
    event = thor.refused("LookDown", "can't look down beyond 60 degrees below the forward horizon")
    assert event.metadata["errorCode"] == "LookDownCantExceedMin"


@pytest.mark.contract("4 LookUp", "4 LookDown")
def test_look_by_degrees(thor):
    thor.ok("Teleport", horizon=0)
    thor.ok("LookDown", degrees=12.5)
    assert thor.agent["cameraHorizon"] == pytest.approx(12.5, abs=0.01)
    thor.ok("LookUp", degrees=7.2)
    assert thor.agent["cameraHorizon"] == pytest.approx(5.3, abs=0.01)
    assert not thor.step("LookUp", degrees=0.05) or thor.agent["cameraHorizon"] * 10 % 1 == pytest.approx(0, abs=1e-3)
    for action in ("LookUp", "LookDown"):
        thor.refused(action, "requires positive degree value", degrees=-5)


@pytest.mark.contract("4 RotateLook")
def test_rotate_look(thor):
    """RotateLook sets both angles without a check, even beyond the limits of LookUp and LookDown."""
    position = thor.position
    for yaw, horizon in ((0, 0), (123, 17), (270, -40), (10, 75)):
        thor.ok("RotateLook", rotation=yaw, horizon=horizon)
        assert thor.yaw == pytest.approx(yaw, abs=0.01)
        assert (thor.agent["cameraHorizon"] + 180) % 360 - 180 == pytest.approx(horizon, abs=0.01)
    assert np.allclose(thor.position, position)


# Standing


@pytest.mark.contract("4 Crouch", "4 Stand")
def test_crouch_and_stand(thor):
    tall = thor.metadata["cameraPosition"]["y"]
    thor.ok("Crouch")
    assert thor.agent["isStanding"] is False and thor.metadata["cameraPosition"]["y"] < tall - 0.2
    thor.refused("Crouch")
    thor.ok("Stand")
    assert thor.agent["isStanding"] is True and thor.metadata["cameraPosition"]["y"] == pytest.approx(tall)
    thor.refused("Stand")


# Teleport


@pytest.mark.contract("4 Teleport")
def test_teleport_keeps_what_is_not_given(thor):
    cell = thor.free_cell()
    thor.ok("Teleport", rotation=90, horizon=30)
    thor.ok("Teleport", position=cell)
    assert thor.yaw == pytest.approx(90, abs=0.01) and thor.agent["cameraHorizon"] == pytest.approx(30, abs=0.01)
    assert np.allclose(thor.position, xyz(cell), atol=1e-2)
    thor.ok("Teleport", standing=False)
    assert thor.agent["isStanding"] is False and np.allclose(thor.position, xyz(cell), atol=1e-2)
    thor.ok("Teleport", rotation={"x": 0, "y": 180, "z": 0}, standing=True)
    assert thor.agent["isStanding"] is True and thor.yaw == pytest.approx(180, abs=0.01)


@pytest.mark.contract("4 Teleport")
def test_teleport_in_the_deprecated_form(thor):
    cell = thor.free_cell()
    thor.ok("Teleport", **cell)
    assert np.allclose(thor.position, xyz(cell), atol=1e-2)


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
@pytest.mark.scenes(4)
def test_teleport_full(thor):
    for _ in range(6):
        cell, yaw, horizon = thor.free_cell(), thor.random.choice([0, 90, 180, 270]), thor.random.choice([-30, 0, 30, 60])
        standing = thor.random.choice([True, False])
        thor.ok("TeleportFull", position=cell, rotation={"x": 0, "y": yaw, "z": 0}, horizon=horizon, standing=standing)
        assert np.allclose(thor.position, xyz(cell), atol=1e-2)
        assert thor.yaw == pytest.approx(yaw, abs=0.01) and thor.agent["cameraHorizon"] == pytest.approx(horizon, abs=0.01)
        assert thor.agent["isStanding"] is standing


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
def test_teleport_refuses_another_height(thor):
    position = {**thor.agent["position"], "y": thor.position[1] + 0.3}
    thor.refused("Teleport", "too large a change", position=position)
    event = thor.refused("TeleportFull", "> 0.05", position=position, rotation=0, horizon=0, standing=True)
    assert "too large a change" in event.metadata["errorMessage"]


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
@pytest.mark.scenes(4)
def test_teleport_refuses_places_that_are_taken(thor):
    """The message names the object; with forceAction the agent is put there."""
    big = sorted(
        (
            o
            for o in thor.metadata["objects"]
            if o["objectType"] in ("Fridge", "Sofa", "Bed", "Bathtub", "CounterTop", "DiningTable", "Dresser", "Toilet", "Desk")
        ),
        key=lambda o: -o["axisAlignedBoundingBox"]["size"]["y"],
    )
    assert big
    box = big[0]["axisAlignedBoundingBox"]
    spot = {axis: round(box["center"][axis] / 0.25) * 0.25 for axis in "xz"} | {"y": thor.position[1]}
    event = thor.refused("Teleport", "Collided with: ", position=spot)
    assert event.metadata["errorMessage"].rstrip(".").split("Collided with: ")[1]
    forced = thor.step("Teleport", position=spot, forceAction=True)
    assert forced and np.allclose(thor.position[[0, 2]], [spot["x"], spot["z"]], atol=1e-3)


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
def test_teleport_refuses_places_outside(thor):
    thor.refused("Teleport", "out of scene bounds", position={**FAR, "y": thor.position[1]})
    thor.refused(
        "TeleportFull", "out of scene bounds", position={**FAR, "y": thor.position[1]}, rotation=0, horizon=0, standing=True
    )


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
def test_teleport_refuses_places_off_the_grid(thor):
    position = {**thor.agent["position"], "x": thor.position[0] + 0.11}
    thor.refused("Teleport", "is not on the grid of size", position=position)
    thor.reset(snapToGrid=False)
    thor.ok("Teleport", position={**thor.agent["position"], "x": thor.position[0] + 0.01})


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
@pytest.mark.parametrize("rotation", [{"x": 20, "y": 0, "z": 0}, {"x": 0, "y": 0, "z": 20}])
def test_teleport_refuses_pitch_and_roll(thor, rotation):
    event = thor.refused("Teleport", "", rotation=rotation)
    assert event.metadata["errorMessage"]


@pytest.mark.contract("4 Teleport", "4 TeleportFull")
@pytest.mark.parametrize("horizon", [-31, 61, 200])
def test_teleport_refuses_horizons(thor, horizon):
    thor.refused("Teleport", "Each horizon must be in [-30:60]", horizon=horizon)


# Reachable positions: see section 2


@pytest.mark.contract("4 GetReachablePositions")
def test_reachable_positions_from_elsewhere_are_the_same(thor):
    """The grid is that of the scene, not of the agent's place in it."""
    one = {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}
    thor.go(thor.free_cell())
    other = {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}
    assert len(one & other) / len(one | other) > 0.95


# Interactable poses


def _targets(thor, count):
    records = [o for o in thor.metadata["objects"] if o["objectType"] not in ("Floor", "Ceiling", "Wall")]
    return thor.random.sample(records, count)


@pytest.mark.contract("4 GetInteractablePoses")
def test_interactable_poses(thor):
    """TeleportFull to each pose works and shows the object; the search leaves the agent where it was."""
    before, found = thor.pose, 0
    for record in _targets(thor, 8):
        event = thor.ok("GetInteractablePoses", objectId=record["objectId"])
        assert thor.pose == pytest.approx(before)
        poses = event.metadata["actionReturn"]
        for pose in thor.random.sample(poses, min(4, len(poses))):
            assert set(pose) == {"x", "y", "z", "rotation", "horizon", "standing"}
            thor.ok("TeleportFull", **pose)
            assert thor.objects[record["objectId"]]["visible"], (record["objectId"], pose)
            found += 1
        thor.ok(
            "TeleportFull",
            position=dict(zip("xyz", before[:3], strict=True)),
            rotation=before[3],
            horizon=before[4],
            standing=True,
        )
    assert found


@pytest.mark.contract("4 GetInteractablePoses")
def test_interactable_poses_among_those_given(thor):
    cells = thor.random.sample(thor.reachable(), 12)
    allowed = {(round(c["x"], 3), round(c["z"], 3)) for c in cells}
    for record in _targets(thor, 6):
        event = thor.ok(
            "GetInteractablePoses",
            objectId=record["objectId"],
            positions=cells,
            rotations=[0, 90],
            horizons=[30],
            standings=[True],
            maxPoses=5,
        )
        poses = event.metadata["actionReturn"]
        assert len(poses) <= 5
        for pose in poses:
            assert (round(pose["x"], 3), round(pose["z"], 3)) in allowed
            assert pose["rotation"] in (0, 90) and pose["horizon"] == 30 and pose["standing"] is True
    near = thor.ok("GetInteractablePoses", objectId=record["objectId"], maxDistance=0.01)
    assert near.metadata["actionReturn"] == []


@pytest.mark.contract("4 GetInteractablePoses")
def test_interactable_poses_of_nothing(thor):
    thor.refused("GetInteractablePoses", objectId="Nothing|+00.00|+00.00|+00.00")


# Paths


def _length(corners):
    points = np.array([xyz(c) for c in corners])
    return float(np.linalg.norm(np.diff(points[:, [0, 2]], axis=0), axis=1).sum())


@pytest.mark.contract("4 GetShortestPath")
@pytest.mark.scenes(3)
def test_shortest_path(thor):
    """Corners lead from the agent to a position from which the object is visible, never shorter than the straight line; nothing
    moves."""
    before, found = thor.pose, 0
    for record in _targets(thor, 8):
        event = thor.step("GetShortestPath", objectId=record["objectId"])
        assert thor.pose == before
        if not event:
            assert event.metadata["errorMessage"]
            continue
        path = event.metadata["actionReturn"]
        assert path["status"] == "PathComplete" and len(path["corners"]) >= 1
        first, last = xyz(path["corners"][0]), xyz(path["corners"][-1])
        assert np.linalg.norm((first - thor.position)[[0, 2]]) < 0.3
        assert _length(path["corners"]) >= np.linalg.norm((last - first)[[0, 2]]) - 1e-3
        found += 1
    assert found


@pytest.mark.contract("4 GetShortestPath")
def test_shortest_path_from_a_position_and_by_type(thor):
    cell = thor.free_cell()
    record = next(o for o in _targets(thor, 12) if thor.step("GetShortestPath", objectId=o["objectId"]))
    path = thor.ok("GetShortestPath", objectId=record["objectId"], position=cell).metadata["actionReturn"]
    assert np.linalg.norm((xyz(path["corners"][0]) - xyz(cell))[[0, 2]]) < 0.3
    kinds = [o["objectType"] for o in thor.metadata["objects"]]
    single = [
        k
        for k in kinds
        if kinds.count(k) == 1
        and thor.step("GetShortestPath", objectId=next(o["objectId"] for o in thor.metadata["objects"] if o["objectType"] == k))
    ]
    kind = thor.random.choice(single)
    assert thor.ok("GetShortestPath", objectType=kind).metadata["actionReturn"]["corners"]


@pytest.mark.contract("4 GetShortestPath")
def test_shortest_path_to_nothing(thor):
    thor.refused("GetShortestPath", "Cannot find sim object", objectId="Nothing|+00.00|+00.00|+00.00")
    thor.refused("GetShortestPath", "Cannot find sim object", objectType="Elephant")


@pytest.mark.contract("4 GetShortestPath")
def test_shortest_path_ignores_movables(thor):
    """The mesh ignores movable objects: one in the way does not change the path."""
    record = next(
        o
        for o in _targets(thor, 20)
        if not o["pickupable"] and not o["moveable"] and thor.step("GetShortestPath", objectId=o["objectId"])
    )
    start = thor.agent["position"]
    before = thor.ok("GetShortestPath", objectId=record["objectId"], position=start).metadata["actionReturn"]["corners"]
    (thing,) = thor.pickupable()
    middle = (xyz(before[0]) + xyz(before[-1])) / 2
    spot = {"x": middle[0], "y": thor.position[1] - 0.5, "z": middle[2]}
    thor.ok(
        "TeleportObject",
        objectId=thing["objectId"],
        position=spot,
        rotation=thing["rotation"],
        forceAction=True,
        forceKinematic=True,
    )
    event = thor.step("GetShortestPath", objectId=record["objectId"], position=start)
    if event and np.linalg.norm(xyz(event.metadata["actionReturn"]["corners"][-1]) - xyz(before[-1])) < 1e-3:
        assert _length(event.metadata["actionReturn"]["corners"]) == pytest.approx(_length(before), abs=1e-3)


# Waiting


@pytest.mark.contract("4 Pass", "4 Done")
@pytest.mark.parametrize("action", ["Pass", "Done"])
def test_waiting_changes_nothing(thor, action):
    before = thor.pose, {k: v["position"] for k, v in thor.objects.items()}
    thor.ok(action)
    assert (thor.pose, {k: v["position"] for k, v in thor.objects.items()}) == before
