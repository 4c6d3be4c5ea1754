"""Random materials, colours and lights: what changes, what must not, and how it is restored. Contract, section 4."""

from __future__ import annotations

import numpy as np
import pytest

VARIATIONS = {"RandomizeMaterials": "ResetMaterials", "RandomizeColors": "ResetColors", "RandomizeLighting": "ResetLighting"}


def view(controller, action="Pass", **arguments):
    event = controller.step(action=action, **arguments)
    assert event.metadata["lastActionSuccess"], event.metadata["errorMessage"]
    return event


@pytest.mark.parametrize("change", VARIATIONS)
def test_look_changes_and_nothing_else(controller, change):
    before = view(controller)
    after = view(controller, change)
    assert (np.abs(after.frame.astype(int) - before.frame).max(axis=2) > 8).mean() > 0.3
    assert (after.depth_frame == before.depth_frame).all()
    assert (after.instance_segmentation_frame == before.instance_segmentation_frame).all()
    assert after.metadata["objects"] == before.metadata["objects"]
    assert (view(controller, VARIATIONS[change]).frame == before.frame).all()
    view(controller, change)
    controller.reset("FloorPlan201")
    assert (view(controller).frame == before.frame).all()


def test_draws_follow_the_seed(controller):
    def drawn(seed):
        view(controller, "SetRandomSeed", seed=seed)
        return [view(controller, "RandomizeMaterials").frame.copy() for _ in range(2)]

    first, again, other = drawn(3), drawn(3), drawn(4)
    assert (np.array(first) == np.array(again)).all()
    assert (first[0] != first[1]).any() and (first[0] != other[0]).any()


def test_room_types(engine):
    world = engine("FloorPlan302")
    assert world.do("RandomizeMaterials", inRoomTypes=["Bedroom", "KITCHEN"])["actionReturn"]["chosenRoomTypes"] == [
        "bedroom",
        "kitchen",
    ]
    for given, start in (
        (["Kitchen"], 'ArgumentException: inRoomTypes must include "bedroom" inside of a bedroom scene: FloorPlan302_physics.'),
        (["Attic"], "ArgumentException: inRoomTypes contains unknown room type: Attic."),
        ([], "ArgumentException: inRoomTypes must have a non-zero length!"),
    ):
        answer = world.do("RandomizeMaterials", inRoomTypes=given)
        assert not answer["lastActionSuccess"] and answer["errorMessage"].startswith(start)


def test_lighting_within_its_ranges(controller):
    """Lights are brighter and darker than the scene's own, and without saturation have the same hue."""
    plain = view(controller).frame.mean()
    assert view(controller, "RandomizeLighting", brightness=[1.6, 1.8], randomizeColor=False).frame.mean() > plain
    assert view(controller, "RandomizeLighting", brightness=[0.3, 0.2], synchronized=True, saturation=[0, 0]).frame.mean() < plain
    view(controller, "RandomizeLighting", brightness=[1, 1], synchronized=True, hue=[0.3, 0.35], saturation=[1, 1])
    red, green, blue = view(controller).frame.reshape(-1, 3).mean(axis=0)
    assert green > red and green > blue


@pytest.fixture(scope="module")
def untouched(engine):
    return engine()


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        ({"randomizeColor": False, "hue": [0, 1]}, "ArgumentException: Cannot pass in randomizeColor=False while also"),
        ({"randomizeColor": False, "saturation": [0, 1]}, "ArgumentException: Cannot pass in randomizeColor=False while also"),
        ({"brightness": [-0.1, 1]}, "ArgumentOutOfRangeException: "),
        ({"hue": [0, 1.1]}, "ArgumentOutOfRangeException: "),
        ({"saturation": [-1, 1]}, "ArgumentOutOfRangeException: "),
        ({"brightness": [1, 2, 3]}, "ArgumentException: Ranges for hue, saturation, and brightness must each have 2 values."),
    ],
)
def test_ranges_that_are_none(untouched, arguments, start):
    answer = untouched.do("RandomizeLighting", **arguments)
    assert not answer["lastActionSuccess"] and answer["errorMessage"].startswith(start), answer["errorMessage"]
