"""Contract, section 4: initialisation, moves, turns, looks and paths of the agent."""

from __future__ import annotations

import numpy as np
import pytest

from conformance.conftest import heading, xyz

# Initialize


def test_initialize_refuses_thirty_degrees_on_the_grid(thor):
    thor.refused("Initialize", "Invalid values 'rotateStepDegrees'", rotateStepDegrees=30, snapToGrid=True)
    thor.ok("Initialize", rotateStepDegrees=30, snapToGrid=False)
    before = thor.yaw
    thor.ok("RotateRight")
    assert (thor.yaw - before) % 360 == pytest.approx(30, abs=1e-2)


def test_initialize_sets_the_limits_of_looking(thor):
    thor.reset(maxUpwardLookAngle=10, maxDownwardLookAngle=15)
    thor.refused("LookDown", "can't look down beyond")
    thor.refused("LookUp", "can't look up beyond")
    thor.ok("LookDown", degrees=15)
    assert thor.agent["cameraHorizon"] == pytest.approx(15, abs=1e-2)


# Moves


@pytest.mark.parametrize(("action", "turn"), [("MoveAhead", 0), ("MoveRight", 90), ("MoveBack", 180), ("MoveLeft", 270)])
def test_move(thor, action, turn):
    """Yaw 0 looks along +z, 90 along +x. A move has the grid's spacing or the requested length, keeps y, and is reversible."""
    thor.reset(snapToGrid=False)
    opposite = {"MoveAhead": "MoveBack", "MoveBack": "MoveAhead", "MoveLeft": "MoveRight", "MoveRight": "MoveLeft"}[action]
    done = 0
    for cell in thor.random.sample(thor.reachable(), 6):
        thor.go(cell, thor.random.choice([0.0, 90.0, 180.0, 270.0, 30.0, 215.0]))
        start = thor.position
        for arguments, length in (({}, 0.25), ({"moveMagnitude": 0.1}, 0.1)):
            if thor.step(action, **arguments):
                assert np.allclose(thor.position - start, length * heading(thor.yaw + turn), atol=1e-3)
                thor.ok(opposite, **arguments)
                assert np.allclose(thor.position, start, atol=1e-3)
                done += 1
    assert done


# Turns


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


# Looking


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


def test_look_by_degrees(thor):
    thor.ok("Teleport", horizon=0)
    thor.ok("LookDown", degrees=12.5)
    assert thor.agent["cameraHorizon"] == pytest.approx(12.5, abs=0.01)
    thor.ok("LookUp", degrees=7.2)
    assert thor.agent["cameraHorizon"] == pytest.approx(5.3, abs=0.01)
    assert not thor.step("LookUp", degrees=0.05) or thor.agent["cameraHorizon"] * 10 % 1 == pytest.approx(0, abs=1e-3)
    for action in ("LookUp", "LookDown"):
        thor.refused(action, "requires positive degree value", degrees=-5)


def test_rotate_look(thor):
    """RotateLook sets both angles without a check, even beyond the limits of LookUp and LookDown."""
    position = thor.position
    for yaw, horizon in ((0, 0), (123, 17), (270, -40), (10, 75)):
        thor.ok("RotateLook", rotation=yaw, horizon=horizon)
        assert thor.yaw == pytest.approx(yaw, abs=0.01)
        assert (thor.agent["cameraHorizon"] + 180) % 360 - 180 == pytest.approx(horizon, abs=0.01)
    assert np.allclose(thor.position, position)


# Standing


def test_crouch_and_stand(thor):
    tall = thor.metadata["cameraPosition"]["y"]
    thor.ok("Crouch")
    assert thor.agent["isStanding"] is False and thor.metadata["cameraPosition"]["y"] < tall - 0.2
    thor.refused("Crouch")
    thor.ok("Stand")
    assert thor.agent["isStanding"] is True and thor.metadata["cameraPosition"]["y"] == pytest.approx(tall)
    thor.refused("Stand")


# Teleport


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


@pytest.mark.scenes(4)
def test_teleport_full(thor):
    for _ in range(6):
        cell, yaw, horizon = thor.free_cell(), thor.random.choice([0, 90, 180, 270]), thor.random.choice([-30, 0, 30, 60])
        standing = thor.random.choice([True, False])
        thor.ok("TeleportFull", position=cell, rotation={"x": 0, "y": yaw, "z": 0}, horizon=horizon, standing=standing)
        assert np.allclose(thor.position, xyz(cell), atol=1e-2)
        assert thor.yaw == pytest.approx(yaw, abs=0.01) and thor.agent["cameraHorizon"] == pytest.approx(horizon, abs=0.01)
        assert thor.agent["isStanding"] is standing


def test_teleport_refuses_places_off_the_grid(thor):
    position = {**thor.agent["position"], "x": thor.position[0] + 0.11}
    thor.refused("Teleport", "is not on the grid of size", position=position)
    thor.reset(snapToGrid=False)
    thor.ok("Teleport", position={**thor.agent["position"], "x": thor.position[0] + 0.01})
