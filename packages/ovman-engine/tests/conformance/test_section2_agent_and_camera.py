"""Contract, section 2: world frame, the agent's body and camera, the grid, and visibility."""

from __future__ import annotations

import re

import numpy as np
import pytest

from conformance.conftest import heading, xyz

MOVES = {"MoveAhead": 0, "MoveRight": 90, "MoveBack": 180, "MoveLeft": 270}


def lattice(positions):
    return np.array([[p["x"], p["z"]] for p in positions])


@pytest.mark.contract("2 world")
def test_moves_follow_the_heading(thor):
    """Yaw 0 looks along +z, 90 along +x; right is clockwise; y is kept."""
    thor.reset(snapToGrid=False)
    moved = set()
    for _ in range(12):
        cell, yaw = thor.free_cell(), thor.random.choice([0.0, 90.0, 180.0, 270.0, 30.0, 215.0])
        for action, turn in MOVES.items():
            thor.go(cell, yaw)
            start = thor.position
            if thor.step(action):
                assert np.allclose(thor.position - start, 0.25 * heading(yaw + turn), atol=1e-3)
                moved.add(action)
    assert moved == set(MOVES)


@pytest.mark.contract("2 world")
def test_turns_are_clockwise_and_reported_from_0_to_360(thor):
    thor.ok("Teleport", rotation=0)
    seen = []
    for _ in range(4):
        thor.ok("RotateRight")
        seen.append(thor.yaw)
    assert np.allclose(np.mod(np.array(seen) + 1, 360) - 1, [90, 180, 270, 0], atol=1e-2)
    thor.ok("Teleport", rotation=-30)
    assert thor.yaw == pytest.approx(330, abs=1e-2)


@pytest.mark.contract("2 default agent")
@pytest.mark.scenes(5)
def test_height_of_agent_and_camera(thor):
    """The camera is 0.675 m above the agent when standing and at it when crouching; the agent is about 0.9 m above the floor."""
    assert 0.85 <= thor.position[1] <= 1.15
    eye = xyz(thor.metadata["cameraPosition"])
    assert np.allclose(eye - thor.position, [0, 0.675, 0], atol=2e-3)
    assert thor.metadata["fov"] == 90 and thor.agent["isStanding"] is True
    thor.ok("Crouch")
    assert thor.agent["isStanding"] is False
    assert np.allclose(xyz(thor.metadata["cameraPosition"]) - thor.position, 0, atol=2e-3)


@pytest.mark.contract("2 default agent", "1.10")
def test_depth_is_planar_and_in_metres(thor):
    """Looking at the floor from a known height: the depth of a row below the horizon is h / tan of the row's angle, the same in
    all columns. Unity's is up to half a percent short."""
    thor.reset(snapToGrid=False)
    checked = 0
    for cell in thor.random.sample(thor.reachable(), 20):
        event = thor.look(position=cell, rotation=thor.random.uniform(0, 360), horizon=0, standing=True)
        floors = [i for i in event.instance_masks if i.startswith("Floor")]
        if not floors:
            continue
        mask = np.logical_or.reduce([event.instance_masks[i] for i in floors])
        mask[:100] = False
        if mask.sum() < 50:
            continue
        floor = thor.objects[floors[0]]["axisAlignedBoundingBox"]
        top = floor["center"]["y"] + floor["size"]["y"] / 2
        drop = event.metadata["cameraPosition"]["y"] - top
        rows = np.arange(150)
        expected = np.broadcast_to((drop / np.maximum((rows + 0.5) / 75 - 1, 1e-9))[:, None], mask.shape)
        assert np.abs(event.depth_frame[mask] / expected[mask] - 1).max() < 0.04
        checked += 1
        if checked == 3:
            break
    assert checked


@pytest.mark.contract("2 default agent", "4 Initialize")
def test_near_and_far_planes(thor):
    returned = thor.ok("Initialize", gridSize=0.25, cameraNearPlane=0.2, cameraFarPlane=12.0).metadata["actionReturn"]
    assert returned["cameraNearPlane"] == pytest.approx(0.2) and returned["cameraFarPlane"] == pytest.approx(12.0)


@pytest.mark.contract("2 locobot")
def test_locobot(thor):
    """The locobot has a low camera and a narrow view; it neither crouches nor strafes."""
    thor.reset(agentMode="locobot", fieldOfView=None, applyActionNoise=False)
    assert thor.metadata["fov"] == pytest.approx(60)
    assert thor.agent["isStanding"] is None
    rise = thor.metadata["cameraPosition"]["y"] - thor.position[1]
    assert rise == pytest.approx(-0.0312, abs=0.02)
    for action in ("Crouch", "Stand"):
        with pytest.raises(ValueError, match="Invalid action"):
            thor.step(action)
    for action in ("MoveLeft", "MoveRight"):
        assert not thor.step(action)
    start = thor.position
    if thor.step("MoveAhead", moveMagnitude=0.25):
        assert 0.1 < np.linalg.norm(thor.position - start) < 0.4
    assert thor.reachable()


@pytest.mark.contract("2 locobot")
def test_default_agent_returns_after_the_locobot(thor):
    thor.reset(agentMode="locobot", fieldOfView=None)
    thor.reset()
    assert thor.metadata["fov"] == 90 and thor.agent["isStanding"] is True


@pytest.mark.contract("2 start position")
@pytest.mark.scenes(6)
def test_start_is_on_the_grid_and_fits_the_distances(thor):
    """`distance` of every object is measured in space from the agent to the object's position."""
    assert np.allclose(thor.position[[0, 2]] / 0.25, np.round(thor.position[[0, 2]] / 0.25), atol=1e-3)
    for record in thor.metadata["objects"]:
        assert record["distance"] == pytest.approx(np.linalg.norm(xyz(record["position"]) - thor.position), abs=2e-3)


@pytest.mark.contract("2 reachable", "4 GetReachablePositions")
@pytest.mark.scenes(5)
def test_reachable_positions(thor):
    """The reachable positions are one connected piece of the lattice around the agent, at its height, with its own cell. The
    agent does not move."""
    before = thor.pose
    positions = thor.reachable()
    assert thor.pose == before
    assert thor.metadata["reachablePositions"] == positions
    assert {tuple(sorted(p)) for p in positions} == {("x", "y", "z")}
    assert all(p["y"] == pytest.approx(thor.position[1], abs=1e-3) for p in positions)
    steps = (lattice(positions) - thor.position[[0, 2]]) / 0.25
    cells = {tuple(c) for c in np.round(steps).astype(int).tolist()}
    assert np.allclose(steps, np.round(steps), atol=1e-2) and len(cells) == len(positions) > 5
    assert (0, 0) in cells
    reached, front = {(0, 0)}, [(0, 0)]
    while front:
        i, j = front.pop()
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if cell in cells - reached:
                reached.add(cell)
                front.append(cell)
    assert reached == cells


@pytest.mark.contract("2 reachable", "2 move test")
def test_reachable_positions_can_be_stood_on_and_walked(thor):
    """TeleportFull to each position works, and so does a step to a neighbouring position."""
    positions = thor.reachable()
    known = {(round(p["x"], 2), round(p["z"], 2)) for p in positions}
    walked = 0
    for cell in thor.random.sample(positions, 12):
        yaw = thor.random.choice([0, 90, 180, 270])
        thor.go(cell, yaw)
        target = thor.position + 0.25 * heading(yaw)
        event = thor.step("MoveAhead")
        if (round(target[0], 2), round(target[2], 2)) in known:
            assert event, event.metadata["errorMessage"]
            walked += 1
    assert walked


@pytest.mark.contract("2 reachable", "4 GetReachablePositions")
def test_grid_size_and_step_count(thor):
    fine, coarse = thor.reachable(gridSize=0.25), thor.reachable(gridSize=0.5)
    assert len(coarse) < len(fine)
    steps = (lattice(coarse) - thor.position[[0, 2]]) / 0.5
    assert np.allclose(steps, np.round(steps), atol=1e-2)
    assert thor.reachable(maxStepCount=10_000) == fine
    thor.refused("GetReachablePositions", "Too many steps taken in GetReachablePositions", maxStepCount=0)


@pytest.mark.contract("2 reachable", "4 GetReachablePositions")
def test_grid_along_the_agents_axes(thor):
    thor.reset(snapToGrid=False)
    thor.ok("Teleport", rotation=45)
    ahead, right = heading(45), heading(135)
    steps = (lattice(thor.reachable(directionsRelativeAgent=True)) - thor.position[[0, 2]]) / 0.25
    along = np.stack([steps @ ahead[[0, 2]], steps @ right[[0, 2]]], axis=1)
    assert len(steps) > 3 and np.allclose(along, np.round(along), atol=0.02)


@pytest.mark.contract("2 reachable")
def test_grid_follows_the_world(thor):
    """An obstacle removes a cell from the grid; without the obstacle the cell is back."""
    before = {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}
    far = [c for c in before if np.hypot(c[0] - thor.position[0], c[1] - thor.position[2]) > 0.8]
    cell = thor.random.choice(far)
    sizes = {o["objectId"]: np.array(list(o["axisAlignedBoundingBox"]["size"].values())) for o in thor.movables()}
    # An obstacle that overlaps the agent would not count.
    small = [o for o in thor.movables() if np.hypot(*sizes[o["objectId"]][[0, 2]]) < 1.0]
    record = max(small, key=lambda o: np.prod(sizes[o["objectId"]]))
    target = {"x": cell[0], "y": thor.position[1], "z": cell[1]}
    thor.ok(
        "TeleportObject",
        objectId=record["objectId"],
        position=target,
        rotation=record["rotation"],
        forceAction=True,
        forceKinematic=True,
    )
    assert cell not in {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}
    thor.ok("DisableObject", objectId=record["objectId"])
    assert cell in {(round(p["x"], 2), round(p["z"], 2)) for p in thor.reachable()}


@pytest.mark.contract("2 visibility")
@pytest.mark.scenes(3)
def test_visible_is_near_and_in_view(thor):
    """Within the visibility distance of the agent's axis, and in the image."""
    seen = 0
    for cell in thor.random.sample(thor.reachable(), 8):
        event = thor.look(position=cell, rotation=thor.random.choice([0, 90, 180, 270]), horizon=30, standing=True)
        for record in event.metadata["objects"]:
            if not record["visible"]:
                continue
            seen += 1
            box = record["axisAlignedBoundingBox"]
            centre, half = xyz(box["center"]), np.array([box["size"][a] for a in "xyz"]) / 2
            gap = np.maximum(np.abs(centre - thor.position) - half, 0)
            assert np.hypot(gap[0], gap[2]) <= 1.5 + 0.02, record["objectId"]
            toward = np.dot(np.maximum(np.abs(centre - thor.position), 0) >= 0, np.ones(3))
            assert toward == 3
    assert seen


@pytest.mark.contract("2 visibility")
def test_nothing_behind_the_agent_is_visible(thor):
    thor.reset(snapToGrid=False)
    for cell in thor.random.sample(thor.reachable(), 8):
        yaw = thor.random.choice([0, 90, 180, 270])
        event = thor.go(cell, yaw)
        for record in event.metadata["objects"]:
            corners = np.array(record["axisAlignedBoundingBox"]["cornerPoints"])
            if ((corners - thor.position) @ heading(yaw)).max() < 0:
                assert not record["visible"], record["objectId"]


@pytest.mark.contract("2 visibility")
def test_more_is_visible_from_farther_away(thor):
    cell, yaw = thor.free_cell(), thor.random.choice([0, 90, 180, 270])
    seen = {}
    for distance in (0.5, 1.5, 5.0):
        thor.reset(visibilityDistance=distance)
        event = thor.go(cell, yaw)
        seen[distance] = {o["objectId"] for o in event.metadata["objects"] if o["visible"]}
    assert seen[0.5] <= seen[1.5] <= seen[5.0]


@pytest.mark.contract("2 visibility")
def test_visibility_scheme_distance(thor):
    thor.reset(visibilityScheme="Distance", visibilityDistance=3.0)
    event = thor.go(thor.free_cell(), 90)
    for record in event.metadata["objects"]:
        if record["visible"]:
            box = record["axisAlignedBoundingBox"]
            gap = np.maximum(np.abs(xyz(box["center"]) - thor.position) - np.array([box["size"][a] for a in "xyz"]) / 2, 0)
            assert np.hypot(gap[0], gap[2]) <= 3.02


@pytest.mark.contract("2 objectId")
@pytest.mark.scenes(5)
def test_names_and_ids(thor):
    """Type and start position, two digits; parts add a type to their parent's id; names are unique."""
    records = thor.metadata["objects"]
    for record in records:
        kind, *rest = record["objectId"].split("|")
        number = r"[+-]?\d\d\.\d\d"
        assert all(re.fullmatch(number, part) for part in rest[:3]) and len(rest) in (3, 4), record["objectId"]
        assert record["objectType"] == (kind if len(rest) == 3 else rest[3]), record["objectId"]
        if len(rest) == 4:
            assert record["objectId"].rsplit("|", 1)[0] in thor.objects
    assert len({r["name"] for r in records}) == len({r["objectId"] for r in records}) == len(records)


@pytest.mark.contract("2 isMoving")
@pytest.mark.scenes(4)
def test_nothing_moves_by_itself(thor):
    before = {o["name"]: (o["position"], o["rotation"]) for o in thor.metadata["objects"]}
    assert thor.metadata["isSceneAtRest"] is True
    for _ in range(10):
        event = thor.ok("Pass")
        assert event.metadata["isSceneAtRest"] is True and not any(o["isMoving"] for o in event.metadata["objects"])
    assert {o["name"]: (o["position"], o["rotation"]) for o in thor.metadata["objects"]} == before


@pytest.mark.contract("2 isMoving")
def test_the_scene_is_at_rest_iff_nothing_moves(thor):
    (record,) = thor.pickupable()
    cell = thor.free_cell()
    target = {"x": cell["x"], "y": thor.position[1] + 0.5, "z": cell["z"]}
    thor.go(thor.random.choice([c for c in thor.reachable() if np.hypot(c["x"] - cell["x"], c["z"] - cell["z"]) > 0.6]))
    thor.ok("TeleportObject", objectId=record["objectId"], position=target, rotation=record["rotation"], forceAction=True)
    rested = []
    for _ in range(80):
        event = thor.ok("Pass")
        moving = [o for o in event.metadata["objects"] if o["isMoving"]]
        assert event.metadata["isSceneAtRest"] is (not moving)
        rested.append(not moving)
    assert rested[-1]
    assert thor.objects[record["objectId"]]["position"]["y"] < target["y"] - 0.1
