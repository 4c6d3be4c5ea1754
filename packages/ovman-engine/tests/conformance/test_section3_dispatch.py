"""Contract, section 3: actions and arguments are matched by name, with AI2-THOR's codes and messages."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.scenes(1)


@pytest.mark.contract("3 unknown")
@pytest.mark.parametrize("name", ["Jump", "moveahead", "", "Move Ahead", "MoveAhead "])
def test_unknown_action(thor, name):
    assert thor.error(name, "InvalidAction", "Invalid action: ") == f"Invalid action: {name}"


@pytest.mark.contract("3 missing")
@pytest.mark.parametrize(
    ("action", "arguments", "missing"),
    [
        ("TeleportFull", {}, {"position", "rotation", "horizon", "standing"}),
        ("TeleportFull", {"position": {"x": 0, "y": 0.9, "z": 0}, "horizon": 0}, {"rotation", "standing"}),
        ("PlaceObjectAtPoint", {}, {"objectId", "position"}),
        ("TeleportObject", {"objectId": "x"}, {"position", "rotation"}),
        ("DisableObject", {}, {"objectId"}),
        ("ChangeResolution", {"x": 100}, {"y"}),
        ("AddThirdPartyCamera", {"position": {"x": 0, "y": 1, "z": 0}}, {"rotation"}),
        ("GetSpawnCoordinatesAboveReceptacle", {}, {"objectId"}),
    ],
)
def test_missing_arguments(thor, action, arguments, missing):
    start = f"action: {action} is missing the following arguments: "
    message = thor.error(action, "MissingArguments", start, **arguments)
    assert set(message.removeprefix(start).split(",")) <= missing and message != start


@pytest.mark.contract("3 superfluous")
@pytest.mark.parametrize(
    "action", ["MoveAhead", "RotateLeft", "Pass", "TeleportFull", "GetReachablePositions", "Crouch", "DisableObject"]
)
def test_superfluous_argument(thor, action):
    required = {
        "TeleportFull": {
            "position": {"x": 0, "y": 0.9, "z": 0},
            "rotation": {"x": 0, "y": 0, "z": 0},
            "horizon": 0,
            "standing": True,
        },
        "DisableObject": {"objectId": "x"},
    }
    message = thor.error(
        action, "InvalidArgument", f'\n\tAction: "{action}" called with invalid argument', zzz=1, **required.get(action, {})
    )
    assert "'zzz'" in message.splitlines()[1]
    for part in ("\n\tExpected arguments:", "\n\tYour arguments:", "\n\tValid ways to call "):
        assert part in message


@pytest.mark.contract("3 unconvertible")
@pytest.mark.parametrize(
    ("action", "arguments", "name"),
    [
        ("MoveAhead", {"moveMagnitude": "far"}, "moveMagnitude"),
        ("MoveAhead", {"moveMagnitude": {"x": 1}}, "moveMagnitude"),
        ("RotateRight", {"degrees": "ninety"}, "degrees"),
        ("GetReachablePositions", {"gridSize": "fine"}, "gridSize"),
    ],
)
def test_unconvertible_argument(thor, action, arguments, name):
    message = thor.error(action, "InvalidArgument", f"action: {action} has an invalid argument: {name} (==", **arguments)
    assert "Cannot convert to: " in message


@pytest.mark.contract("3 unconvertible")
def test_number_for_a_vector_fails_in_one_way_or_the_other(thor):
    try:
        event = thor.step("TeleportObject", objectId="x", position=5, rotation={"x": 0, "y": 0, "z": 0})
    except ValueError:
        event = thor.controller.last_event
    assert not event and event.metadata["errorMessage"]


@pytest.mark.contract("3 exception")
def test_exception_in_an_action(thor):
    event = thor.refused("RotateRight", "InvalidOperationException: Cannot rotate by 0 degrees", degrees=0)
    assert ". trace:" in event.metadata["errorMessage"]


@pytest.mark.contract("3 extra keys")
@pytest.mark.parametrize("action", ["MoveAhead", "Pass", "Teleport", "GetReachablePositions"])
def test_keys_that_every_action_accepts(thor, action):
    """The renderer's flags and the client's own keys are never superfluous arguments."""
    for key in ("renderObjectImage", "renderClassImage", "renderNormalsImage", "renderInstanceSegmentation"):
        thor.step(action, **{key: False})
    thor.step(action, agentId=0)
    thor.step(action, sequenceId=4242)
    thor.controller.step(action=action, renderImage=True)


@pytest.mark.contract("3 server actions")
@pytest.mark.parametrize("action", ["LookUp", "LookDown", "RotateLook", "Initialize"])
def test_actions_of_the_old_style_take_anything(thor, action):
    thor.ok("Teleport", horizon=0)
    thor.ok(action, zzz=1, **({"rotation": 90, "horizon": 0} if action == "RotateLook" else {}))


@pytest.mark.contract("3 server actions", "4 SetObjectPoses")
def test_set_object_poses_takes_anything(thor):
    thor.ok("SetObjectPoses", objectPoses=thor.poses(), zzz=[1])


@pytest.mark.contract("3 matching")
def test_a_refused_action_changes_nothing(thor):
    before, objects = thor.pose, thor.objects
    for name, arguments in (
        ("Nothing", {}),
        ("MoveAhead", {"zzz": 1}),
        ("TeleportFull", {}),
        ("MoveAhead", {"moveMagnitude": []}),
    ):
        with pytest.raises(ValueError):
            thor.step(name, **arguments)
    assert thor.pose == before
    assert {k: v["position"] for k, v in thor.objects.items()} == {k: v["position"] for k, v in objects.items()}
