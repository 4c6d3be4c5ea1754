"""Dispatch: which actions and arguments are matched, converted or refused, with which code and message."""

from __future__ import annotations

import math
import typing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.actions import TABLE, dispatch
from ovman_engine.actions.registry import Action, Failed, Thrown, action
from ovman_engine.actions.values import Inconvertible, Malformed, ObjectPose, PartialVector3, Vector3, converted
from ovman_engine.world.errors import Refused


@pytest.fixture
def probe(monkeypatch):
    """`probe(function, ...)` registers functions as overloads of the action "Probe" for the length of a test."""
    monkeypatch.setitem(TABLE, "Probe", [])

    def register(*functions):
        for function in functions:
            action("Probe")(function)

    return register


def perform(**request):
    return dispatch.perform(None, request)


def one(engine, a: float, b: int = 3, c: str | None = None) -> tuple:
    return a, b, c


def test_defaults_and_conversions(probe):
    probe(one)
    assert perform(action="Probe", a=1).value == (1.0, 3, None)
    assert perform(action="Probe", a="2.5", b=4.0, c=None).value == (2.5, 4, None)
    assert perform(action="Probe", a=True, b="7", c=5).value == (1.0, 7, "5")


def test_unknown_action():
    for name in ("Fly", "", None, 7, ["Pass"], "moveahead"):
        outcome = perform(action=name)
        assert not outcome.success and outcome.code == "InvalidAction" and outcome.message.startswith("Invalid action: ")
    assert perform(action="Fly").message == "Invalid action: Fly"
    assert perform().code == "InvalidAction"


def test_missing_arguments(probe):
    def two(engine, x: float, y: float, z: float = 0.0) -> None: ...

    probe(two)
    outcome = perform(action="Probe", z=1)
    assert (outcome.code, outcome.message) == ("MissingArguments", "action: Probe is missing the following arguments: x,y")


def test_superfluous_argument(probe):
    probe(one)
    outcome = perform(action="Probe", a=1, z=2)
    assert outcome.code == "InvalidArgument"
    assert outcome.message == (
        "\n\tAction: \"Probe\" called with invalid argument: 'z'"
        "\n\tExpected arguments: Single a, Int32 b = 3, String c = "
        "\n\tYour arguments: 'a', 'z'"
        '\n\tValid ways to call "Probe" action:\n\t\tVoid Probe(Single a, Int32 b = 3, String c = )'
    )
    assert "invalid arguments: 'y', 'z'" in perform(action="Probe", y=1, z=2).message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"a": "abc"}, "a (==abc). Cannot convert to: float"),
        ({"a": math.nan}, "a (==NaN). Cannot convert to: float"),
        ({"a": math.inf}, "a (==Infinity). Cannot convert to: float"),
        ({"a": None}, "a (==). Cannot convert to: float"),
        ({"a": 1, "b": "x"}, "b (==x). Cannot convert to: int"),
        ({"a": 1, "b": 1e300}, "b (==1e+300). Cannot convert to: int"),
        ({"a": 1, "c": [1]}, "c (==[\n  1\n]). Cannot convert to: String"),
    ],
)
def test_unconvertible_argument(probe, arguments, words):
    probe(one)
    outcome = perform(action="Probe", **arguments)
    assert (outcome.code, outcome.message) == ("InvalidArgument", f"action: Probe has an invalid argument: {words}")


def test_a_vector_that_is_none_fails_without_a_code(probe):
    def place(engine, position: Vector3) -> float:
        return position.x

    probe(place)
    outcome = perform(action="Probe", position=5)
    assert not outcome.success and outcome.code is None and "Vector3" in outcome.message
    assert perform(action="Probe", position={"x": 1, "w": 2}).value == 1.0


def test_overloads_are_matched_by_names(probe):
    def by_point(engine, position: Vector3, turn: float = 0.0) -> str:
        return "point"

    def by_numbers(engine, x: float, y: float, z: float, turn: float = 0.0) -> str:
        return "numbers"

    probe(by_numbers, by_point)
    assert perform(action="Probe", position={}).value == "point"
    assert perform(action="Probe", x=1, y=2, z=3).value == "numbers"
    assert perform(action="Probe", x=1, y=2).message.endswith("missing the following arguments: z")
    assert perform(action="Probe").message.endswith("missing the following arguments: position")


def test_what_takes_anything_takes_anything_but_converts_what_it_names(probe):
    def loose(engine, degrees: float = 0.0, **rest: object) -> float:
        return degrees

    probe(loose)
    assert perform(action="Probe", degrees=3, colour="red", sequenceId=1).value == 3.0
    outcome = perform(action="Probe", degrees="red")
    assert not outcome.success and outcome.code is None and "degrees" in outcome.message


def test_strict_mode_names_an_unknown_argument(probe, monkeypatch):
    def loose(engine, degrees: float = 0.0, **rest: object) -> float:
        return degrees

    probe(loose)
    monkeypatch.setenv("OVMAN_ENGINE_STRICT", "1")
    assert perform(action="Probe", degrees=3, sequenceId=1).success
    outcome = perform(action="Probe", degrees=3, colour="red")
    assert outcome.code == "InvalidArgument"
    assert outcome.message == "Probe does not know the argument 'colour' (OVMAN_ENGINE_STRICT=1)"


def test_strict_mode_accepts_what_the_client_sends(start, monkeypatch):
    monkeypatch.setenv("OVMAN_ENGINE_STRICT", "1")
    with start(scene="FloorPlan201", renderDepthImage=True, gridSize=0.25) as controller:
        controller.reset("FloorPlan1")
        assert controller.step("LookUp")
        with pytest.raises(ValueError, match="SetObjectPoses does not know the argument 'skipMovable'"):
            controller.step("SetObjectPoses", objectPoses=[], skipMovable=True)


def test_keys_that_any_action_may_carry(probe):
    probe(one)
    carried = dict.fromkeys(dispatch.ALWAYS_ACCEPTED - {"action"}, True)
    assert perform(action="Probe", a=1, **carried).success


def test_refusals_codes_and_exceptions(probe):
    failures = {
        "refused": Refused("no"),
        "coded": Failed("too far", "LookDownCantExceedMin"),
        "thrown": Thrown("InvalidOperationException", "Collided"),
        "bug": ZeroDivisionError("oh"),
    }

    def fail(engine, how: str) -> None:
        raise failures[how]

    probe(fail)
    assert (perform(action="Probe", how="refused").message, perform(action="Probe", how="refused").code) == ("no", None)
    assert perform(action="Probe", how="coded").code == "LookDownCantExceedMin"
    assert perform(action="Probe", how="thrown").message.startswith("InvalidOperationException: Collided. trace: ")
    assert perform(action="Probe", how="bug").message.startswith("ZeroDivisionError: oh. trace: ")


TAKE_ANYTHING = {"CreateHouse", "InitialRandomSpawn"}
"""Actions that check an argument themselves."""


def test_every_action_has_a_signature_that_arguments_can_be_converted_to():
    kinds = {float, int, bool, str, Vector3, PartialVector3, ObjectPose}
    for name, ways in TABLE.items():
        for way in ways:
            assert isinstance(way, Action) and way.name == name
            for parameter in way.parameters:
                kind = parameter.kind
                inner = typing.get_args(kind)[0] if typing.get_origin(kind) is list else kind
                if inner is typing.Any:
                    assert name in TAKE_ANYTHING, (name, parameter)
                else:
                    assert inner in kinds, (name, parameter)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("xyzw"), inner, max_size=3),
    max_leaves=6,
)


@given(
    value=json_values,
    kind=st.sampled_from(
        [float, int, bool, str, Vector3, PartialVector3, ObjectPose, list[float], list[Vector3], list[ObjectPose]]
    ),
)
def test_conversion_gives_its_kind_or_says_that_it_cannot(value, kind):
    try:
        result = converted(value, kind)
    except (Inconvertible, Malformed):
        return
    assert isinstance(result, typing.get_origin(kind) or kind)
    if kind is float:
        assert math.isfinite(result)
    if kind is Vector3:
        assert all(map(math.isfinite, result.array))
