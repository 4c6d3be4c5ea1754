"""Contract, section 2: world frame, the agent's body and camera, the grid, and visibility."""

from __future__ import annotations

import numpy as np
import pytest

from conformance.conftest import xyz


def lattice(positions):
    return np.array([[p["x"], p["z"]] for p in positions])


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
