"""The kinds of agent: body, camera, motion and arguments. Contract, sections 2 and 4."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman_engine.bodies.embodiment import DEFAULT, LOCOBOT
from ovman_engine.plan import floorplan
from ovman_engine.world.world import World


def pose(agent):
    me = agent["agent"]
    return (*(me["position"][k] for k in "xyz"), me["rotation"]["y"], me["cameraHorizon"], me["isStanding"])


def camera_m(agent):
    return agent["cameraPosition"]["y"] - agent["agent"]["position"]["y"]


def flat(points):
    return {(round(p["x"], 4), round(p["z"], 4)) for p in points}


def failure(agent):
    assert not agent["lastActionSuccess"]
    return agent["errorCode"], agent["errorMessage"]


# The default agent


@given(start=st.floats(-30, 60), tenths=st.integers(1, 900), down=st.booleans())
def test_a_look_goes_exactly_as_far_as_asked_or_not_at_all(engine, start, tenths, down):
    e = shared_engine(engine)
    e.do("RotateLook", horizon=start)
    before = e.agent["agent"]["cameraHorizon"]
    degrees = tenths / 10
    e.do("LookDown" if down else "LookUp", degrees=degrees)
    after = e.agent["agent"]["cameraHorizon"]
    wanted = before + (degrees if down else -degrees)
    if e.agent["lastActionSuccess"]:
        assert after == pytest.approx(wanted, abs=1e-6) and -30.05 <= after <= 60.05
    else:
        assert after == before and not -29.95 < wanted < 59.95
        assert failure(e.agent)[0] == "LookDownCantExceedMin"


_engines: dict = {}


def shared_engine(engine):
    if "one" not in _engines:
        _engines["one"] = engine()
    return _engines["one"]


def test_what_overlaps_the_agent_does_not_count(engine):
    """Contract, section 2: an edge is free if the sweep hits nothing except what overlaps the agent at its start."""
    e = engine()
    table = next(o for o in e.agent["objects"] if o["objectType"] == "CoffeeTable")
    e.do("DisableObject", objectId=table["objectId"])
    without = flat(e.do("GetReachablePositions")["actionReturn"])
    e.do("EnableObject", objectId=table["objectId"])
    spot = {"x": table["axisAlignedBoundingBox"]["center"]["x"], "z": table["axisAlignedBoundingBox"]["center"]["z"]}
    y = e.agent["agent"]["position"]["y"]
    assert len(flat(e.do("GetReachablePositions")["actionReturn"])) < len(without)
    near = min(({"x": x, "y": y, "z": z} for x, z in without), key=lambda p: math.hypot(p["x"] - spot["x"], p["z"] - spot["z"]))
    assert "Collided with" in failure(e.do("Teleport", position=near))[1]
    e.do("Teleport", position=near, forceAction=True)
    assert flat(e.do("GetReachablePositions")["actionReturn"]) == without


# The locobot


@pytest.fixture(scope="module")
def robot(engine):
    return engine(agentMode="locobot", applyActionNoise=False)


def test_a_locobot_through_the_client(reset):
    with pytest.warns(UserWarning, match="renamed to agentMode='locobot'"):
        controller = reset("FloorPlan201", agentMode="bot", renderDepthImage=True)
    event = controller.last_event
    assert event.metadata["agent"]["isStanding"] is None and event.metadata["fov"] == 60
    assert camera_m(event.metadata) == pytest.approx(-0.0312)
    assert event.frame.shape == (300, 300, 3) and event.depth_frame.min() > 0
    for action in ("Crouch", "Stand"):
        with pytest.raises(ValueError, match=f"^Invalid action: {action}$"):
            controller.step(action)
    for action in ("MoveLeft", "MoveRight"):
        refused = controller.step(action)
        assert not refused and "does not support horizontal movement" in refused.metadata["errorMessage"]
    with pytest.raises(ValueError, match="called with invalid argument: 'standing'"):
        controller.step("Teleport", horizon=10, standing=True)
    spot = event.metadata["agent"]["position"]
    assert controller.step("TeleportFull", position=spot, rotation=40, horizon=-30)
    assert controller.last_event.metadata["agent"]["rotation"]["y"] == 40
    assert controller.reset("FloorPlan201").metadata["agent"]["isStanding"] is None
    default = controller.reset("FloorPlan201", agentMode="default").metadata
    assert default["agent"]["isStanding"] is True and default["fov"] == 90


def test_a_locobot_errs_a_little_and_the_same_way_from_the_same_seed(engine):
    e = engine(agentMode="locobot", rotateStepDegrees=90)

    def walk(seed):
        e.do("Reset")
        e.do("Initialize", agentMode="locobot")
        e.do("SetRandomSeed", seed=seed)
        poses = []
        for action in ("RotateRight", "RotateLeft", "MoveAhead", "MoveBack") * 5:
            before = pose(e.agent)
            after = pose(e.do(action))
            turn = (after[3] - before[3] + 180) % 360 - 180
            length = math.hypot(after[0] - before[0], after[2] - before[2])
            if action.startswith("Rotate"):
                error, spread = abs(turn) - 90, 0.5
                assert length == 0
            else:
                error, spread = length - 0.25, 0.005
                assert abs(turn) < 6 * 0.25
            assert e.agent["lastActionSuccess"] and 0 < abs(error) < 6 * spread + 0.001
            poses.append(after)
        return poses

    one = walk(3)
    assert walk(3) == one != walk(4)


def test_noise_has_the_spread_that_it_is_given(engine):
    e = engine(agentMode="locobot", rotateGaussianSigma=5.0)
    turns = []
    for _ in range(150):
        before = e.agent["agent"]["rotation"]["y"]
        after = e.do("RotateRight", degrees=45, renderImage=False)["agent"]["rotation"]["y"]
        turns.append((after - before) % 360 - 45)
    assert abs(np.mean(turns)) < 5 * 4 / math.sqrt(150) and 4 < np.std(turns) < 6


def test_without_noise_a_locobot_is_exact(robot):
    robot.do("Teleport", rotation={"x": 0, "y": 0, "z": 0})
    before = pose(robot.agent)
    assert pose(robot.do("MoveAhead"))[:4] == pytest.approx((before[0], before[1], before[2] + 0.25, 0))
    assert pose(robot.do("MoveBack", moveMagnitude=0.25))[:4] == pytest.approx(before[:4])
    assert pose(robot.do("MoveAhead", noise=0.05, forceAction=True))[2] == pytest.approx(before[2] + 0.3)
    assert pose(robot.do("RotateRight", degrees=10))[3] == 10 and pose(robot.do("RotateRight", degrees=0))[3] == 40
    assert "moveMagnitude must be null or >= 0." in failure(robot.do("MoveAhead", moveMagnitude=0))[1]
    assert failure(robot.do("LookUp", degrees=10))[1] == "Must have degrees == 0 for now."
    assert robot.do("RotateLook", horizon=0)["agent"]["cameraHorizon"] == 0
    assert [robot.do("LookDown")["agent"]["cameraHorizon"] for _ in range(2)] == [30, 60]
    assert failure(robot.do("LookDown"))[0] == "LookDownCantExceedMin"


@pytest.mark.parametrize("name", ["FloorPlan3", "FloorPlan201"])
def test_a_smaller_agent_goes_wherever_a_larger_one_goes(name):
    world = World(floorplan.load(name))
    large = {(x, z) for x, _, z in world.reachable()}
    world.agent.embodiment = LOCOBOT
    small = {(x, z) for x, _, z in world.reachable()}
    assert large <= small
    world.agent.embodiment = DEFAULT
    assert {(x, z) for x, _, z in world.reachable()} == large


# Initialize


@pytest.mark.parametrize("mode", ["drone", ""])
def test_modes_that_there_are_not(engine, mode):
    e = shared_engine(engine)
    before = pose(e.agent)
    message = failure(e.do("Initialize", agentMode=mode))[1]
    assert message == f"Unsupported agent mode: {mode}. This engine has the agent modes 'default' and 'locobot'."
    assert pose(e.agent) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fieldOfView": 180}, "fov must be set to (0, 180) noninclusive."),
        ({"timeScale": 0}, "Time scale must be > 0"),
        ({"rotateStepDegrees": -90}, "rotateStepDegrees must be a non-zero, non-negative float"),
        ({"maxDownwardLookAngle": -1}, "maxDownwardLookAngle must be a non-negative float"),
        ({"gridSize": 5.5}, "grid size must be in the range (0,5]"),
    ],
)
def test_what_initialize_refuses(engine, arguments, message):
    assert failure(shared_engine(engine).do("Initialize", **arguments)) == (None, message)


@settings(max_examples=12, derandomize=True, deadline=None)
@given(grid=st.sampled_from([0.1, 0.15, 0.25, 0.3, 0.5]), snap=st.booleans())
def test_the_agent_begins_on_its_grid(engine, grid, snap):
    e = shared_engine(engine)
    e.do("Reset")
    before = pose(e.agent)
    after = pose(e.do("Initialize", gridSize=grid, snapToGrid=snap))
    assert e.agent["lastActionSuccess"]
    for k in (0, 2):
        assert after[k] / grid == pytest.approx(round(after[k] / grid), abs=1e-3) and abs(after[k] - before[k]) < grid
    assert after[1] == before[1]
    e.do("Reset")
    e.do("Initialize", snapToGrid=False, rotateStepDegrees=30)
