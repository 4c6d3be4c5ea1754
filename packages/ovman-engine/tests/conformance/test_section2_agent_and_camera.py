"""Contract, section 2: world frame, the agent's body and camera, the grid, and visibility."""

from __future__ import annotations

import re

import numpy as np
import pytest

from conformance.conftest import heading, xyz

MOVES = {"MoveAhead": 0, "MoveRight": 90, "MoveBack": 180, "MoveLeft": 270}


def lattice(positions):
    return np.array([[p["x"], p["z"]] for p in positions])


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


def test_depth_is_planar_and_in_metres(thor):
    """Looking at the floor from a known height: the depth of a row below the horizon is h / tan of the row's angle, the same in
    all columns. Unity's is up to half a percent short.
    """
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


@pytest.mark.scenes(5)
def test_reachable_positions(thor):
    """The reachable positions are one connected piece of the lattice around the agent, at its height, with its own cell. The
    agent does not move.
    """
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
