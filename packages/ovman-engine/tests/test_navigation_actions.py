"""Shortest paths and interactable poses: usable, taut, free, complete, and without any effect."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from ovman_engine.actions.navigation import _floor

SCENES = ("FloorPlan8", "FloorPlan404")


def xz(point):
    return np.array([point["x"], point["z"]])


def full(pose):
    return {**pose, "rotation": {"x": 0, "y": pose["rotation"], "z": 0}}


def length(corners):
    return sum(float(np.linalg.norm(xz(b) - xz(a))) for a, b in pairwise(corners))


def state(scene):
    return scene.agent["agent"], scene.agent["objects"]


@pytest.fixture(scope="module", params=SCENES)
def scene(engine, request):
    return engine(request.param, snapToGrid=True, rotateStepDegrees=90, fastActionEmit=False)


# GetInteractablePoses


def test_every_pose_shows_the_object_and_no_other_does(scene):
    """TeleportFull to each pose shows the object, and every pose from which it is interactable and wholly near is among them."""
    before = state(scene)
    rng = np.random.default_rng(3)
    cells = scene.do("GetReachablePositions")["actionReturn"]
    found = {}
    for record in before[1][::6]:
        poses = scene.do("GetInteractablePoses", objectId=record["objectId"])["actionReturn"]
        assert scene.agent["lastActionSuccess"], scene.agent["errorMessage"]
        assert state(scene) == before
        keys = [(p["x"], p["z"], p["rotation"], p["horizon"], p["standing"]) for p in poses]
        assert len(set(keys)) == len(keys)
        found[record["objectId"]] = {(round(x, 3), round(z, 3), *rest) for x, z, *rest in keys}
        for k in rng.permutation(len(poses))[:2]:
            assert set(poses[k]) == {"x", "y", "z", "rotation", "horizon", "standing"}
            assert scene.do("TeleportFull", **full(poses[k]))["lastActionSuccess"], scene.agent["errorMessage"]
            assert scene.object(record["objectId"])["visible"], (record["objectId"], poses[k])
        scene.do("TeleportFull", **{k: before[0][k] for k in ("position", "rotation")}, horizon=0, standing=True)
    assert sum(map(bool, found.values())) > 0.6 * len(found)
    for _ in range(25):
        cell, standing = cells[rng.integers(len(cells))], bool(rng.integers(2))
        yaw, horizon = float(90 * rng.integers(4)), float(rng.choice([-30, 0, 30, 60]))
        scene.do("TeleportFull", position=cell, rotation={"y": yaw}, horizon=horizon, standing=standing)
        for record in scene.agent["objects"]:
            box = np.array(record["axisAlignedBoundingBox"]["cornerPoints"])[:, [0, 2]]
            wholly_near = np.linalg.norm(box - xz(cell), axis=1).max() < 1.5
            if record["isInteractable"] and wholly_near and record["objectId"] in found:
                pose = (round(cell["x"], 3), round(cell["z"], 3), yaw, horizon, standing)
                assert pose in found[record["objectId"]], (record["objectId"], pose)
    scene.do("TeleportFull", **{k: before[0][k] for k in ("position", "rotation")}, horizon=0, standing=True)


@pytest.fixture(scope="module")
def lounge(engine):
    """A scene that no test changes, and the id of its sofa."""
    scene = engine("FloorPlan206", rotateStepDegrees=90)
    return scene, next(o for o in scene.agent["objects"] if o["objectType"] == "Sofa")["objectId"]


def test_poses_are_chosen_among_those_given(lounge):
    scene, target = lounge
    cells = scene.do("GetReachablePositions")["actionReturn"]
    every = scene.do("GetInteractablePoses", objectId=target)["actionReturn"]
    given = scene.do(
        "GetInteractablePoses", objectId=target, positions=cells[::3], rotations=[90, 45], horizons=[30], standings=[True]
    )["actionReturn"]
    assert given and {p["rotation"] for p in given} <= {90, 45} and {(p["horizon"], p["standing"]) for p in given} == {(30, True)}
    assert {(p["x"], p["z"]) for p in given} <= {(c["x"], c["z"]) for c in cells[::3]}
    alike = [p for p in every if p["rotation"] == 90 and p["horizon"] == 30 and p["standing"]]
    assert [p for p in given if p["rotation"] == 90] == [p for p in alike if {k: p[k] for k in "xyz"} in cells[::3]]
    assert scene.do("GetInteractablePoses", objectId=target, maxPoses=7)["actionReturn"] == every[:7]
    near = scene.do("GetInteractablePoses", objectId=target, maxDistance=0.8)["actionReturn"]
    assert near and all(p in every for p in near) and len(near) < len(every)
    assert scene.do("GetInteractablePoses", objectId=target, maxDistance=0.01)["actionReturn"] == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"objectId": "Nothing|+00.00|+00.00|+00.00"}, "Cannot find sim object"),
        ({"maxPoses": 0}, "maxPoses must be > 0"),
        ({"maxDistance": -1.0}, "maxDistance must be >= 0"),
        ({"horizons": [0, 75]}, "Each horizon must be in [-30:60]. You gave 75"),
        ({"horizons": []}, "Every degree of freedom must have at least 1 valid value"),
        ({"positions": []}, "Every degree of freedom must have at least 1 valid value"),
        ({"standings": []}, "Every degree of freedom must have at least 1 valid value"),
    ],
)
def test_poses_cannot_be_told_of_nothing(lounge, arguments, message):
    scene, target = lounge
    refused = scene.do("GetInteractablePoses", **{"objectId": target, **arguments})
    assert not refused["lastActionSuccess"] and message in refused["errorMessage"], refused["errorMessage"]


# Shortest paths


def test_paths_are_taut_and_free_and_no_longer_than_a_walk(scene):
    """Paths between reachable positions stay on the floor, are never shorter than the straight line nor longer than on the
    lattice, have no superfluous corner, and are as long in reverse.
    """
    before = state(scene)
    floor, rng = _floor(scene.engine.session), np.random.default_rng(5)
    cells = scene.do("GetReachablePositions")["actionReturn"]
    at = {(round(c["x"] / 0.25), round(c["z"] / 0.25)): c for c in cells}
    bent = 0
    for _ in range(8):
        start, end = cells[rng.integers(len(cells))], cells[rng.integers(len(cells))]
        path = scene.do("GetShortestPathToPoint", position=start, **end)["actionReturn"]
        assert scene.agent["lastActionSuccess"], scene.agent["errorMessage"]
        assert path["status"] == "PathComplete" and state(scene) == before
        corners = np.array([xz(c) for c in path["corners"]])
        assert np.allclose(corners[0], xz(start), atol=1e-4) and np.allclose(corners[-1], xz(end), atol=1e-4)
        dense = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(corners)]) if len(corners) > 1 else corners
        assert floor.free(dense).all()
        assert np.linalg.norm(xz(end) - xz(start)) - 1e-6 <= length(path["corners"]) <= walk(at, start, end) + 1e-6
        if len(corners) > 2:
            bent += 1
            assert not floor.joined(corners[:-2], corners[2:]).any()
        back = scene.do("GetShortestPathToPoint", position=end, **start)["actionReturn"]
        assert length(back["corners"]) == pytest.approx(length(path["corners"]), rel=0.02, abs=0.02)
    assert bent or scene.engine.session.scene_name != "FloorPlan8_physics"  # in others nearly all furniture can be moved


def walk(at, start, end):
    """Length of the shortest walk along the axes over reachable places, metres."""
    key = {tuple(np.round(xz(c) / 0.25).astype(int)): c for c in (start, end)}
    goal, front, steps = list(key)[-1], {next(iter(key))}, 0
    seen = set(front)
    while goal not in front:
        front = {(i + a, j + b) for i, j in front for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))} & set(at)
        front -= seen
        assert front, "not one piece"
        seen |= front
        steps += 1
    return 0.25 * steps


def test_a_path_to_an_object_ends_where_it_can_be_seen(scene):
    """The target is reachable and shows the object, and no position that needs fewer steps does."""
    before = state(scene)
    cells = {(round(c["x"], 3), round(c["z"], 3)) for c in scene.do("GetReachablePositions")["actionReturn"]}
    complete, sampled = 0, before[1][::4]
    for record in sampled:
        outcome = scene.do("GetShortestPath", objectId=record["objectId"])
        assert state(scene) == before
        if not outcome["lastActionSuccess"]:
            assert outcome["errorMessage"].startswith(
                (f"Target object {record['objectId']} is not visible", "No point", "Could not")
            )
            continue
        complete += 1
        last = outcome["actionReturn"]["corners"][-1]
        place = min(cells, key=lambda c: np.hypot(c[0] - last["x"], c[1] - last["z"]))
        assert np.hypot(place[0] - last["x"], place[1] - last["z"]) < 0.21
        poses = scene.do(
            "GetInteractablePoses",
            objectId=record["objectId"],
            positions=[{"x": place[0], "y": before[0]["position"]["y"], "z": place[1]}],
            rotations=list(range(0, 360, 15)),
            horizons=[-30, -15, 0, 15, 30, 45, 60],
            standings=[True],
        )["actionReturn"]
        assert poses or record["position"]["y"] > 2.2 or record["position"]["y"] < 0.2, record["objectId"]
    assert complete > 0.5 * len(sampled)


def test_movables_are_no_obstacle_to_a_path(engine):
    scene = engine("FloorPlan206")
    cells = scene.do("GetReachablePositions")["actionReturn"]
    start, end = cells[0], cells[-1]
    free = scene.do("GetShortestPathToPoint", position=start, **end)["actionReturn"]
    box = next(o for o in scene.agent["objects"] if o["objectType"] in ("ArmChair", "Chair", "Box"))["objectId"]
    middle = free["corners"][len(free["corners"]) // 2]
    scene.do("TeleportObject", objectId=box, position={**middle, "y": 0.5}, forceAction=True, forceKinematic=True)
    assert scene.agent["lastActionSuccess"], scene.agent["errorMessage"]
    left = scene.do("GetReachablePositions")["actionReturn"]
    assert any(cell not in left for cell in cells)
    assert scene.do("GetShortestPathToPoint", position=start, **end)["actionReturn"] == free


def test_paths_to_nothing_are_refused(engine):
    scene = engine("FloorPlan8")
    cell = scene.do("GetReachablePositions")["actionReturn"][3]
    outside = {"x": 50.0, "y": 0.9, "z": 50.0}

    def message(action, **arguments):
        outcome = scene.do(action, **arguments)
        assert not outcome["lastActionSuccess"] and outcome["actionReturn"] is None
        return outcome["errorMessage"]

    assert message("GetShortestPath", objectId="Nothing|1|2|3") == "Cannot find sim object with id 'Nothing|1|2|3'"
    assert "Object type 'Elephant' was not found" in message("GetShortestPath", objectType="Elephant")
    assert "cannot disambiguate" in message("GetShortestPath", objectType="Cabinet")
    assert message("GetShortestPath").startswith("ArgumentNullException")
    assert message("GetShortestPathToPoint", **outside).startswith("No point on NavMesh near (50.000, ")
    assert message("GetShortestPathToPoint", position=outside, **cell).startswith("No point on NavMesh near (50.000, ")
    assert "allowedError" in message("GetShortestPathToPoint", **cell, allowedError=-1)
    assert scene.do("GetShortestPath", objectId="x", rotation={"y": 0})["errorCode"] == "MissingArguments"
    hidden = next(o for o in scene.agent["objects"] if o["objectType"] == "Cabinet")["objectId"]
    scene.do("DisableObject", objectId=hidden)
    assert f"Target object {hidden} is not visible on navigation path" in message("GetShortestPath", objectId=hidden)
