"""Facts that AI2-THOR's own tests assert of FloorPlan28, FloorPlan1 and FloorPlan402 in Unity.

Source: ai2thor/tests/test_unity.py and unity/Assets/UnitTests of github.com/allenai/ai2thor.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from conformance.conftest import Thor, xyz

HEIGHT_M = 0.900998235
MM = 1e-3
SHELF, TABLE, FLOOR = "Shelf|-04.03|+00.49|-00.30", "SideTable|-04.03|+00.00|-00.30", "Floor|+00.00|+00.00|+00.00"


@pytest.fixture
def kitchen(reset: Callable[..., Any]) -> Thor:
    """FloorPlan28 as a client starts it."""
    return Thor(reset, "FloorPlan28", "unity")


def at(x: float, z: float) -> dict[str, float]:
    return {"x": x, "y": HEIGHT_M, "z": z}


@pytest.mark.parametrize(("room", "position", "yaw"), [("FloorPlan28", (-1.5, -1.5), 180.0), ("FloorPlan1", (-1.0, 1.0), 270.0)])
def test_the_agent_starts_as_in_unity(kitchen: Thor, room: str, position: tuple[float, float], yaw: float) -> None:
    kitchen.reset(room)
    assert np.allclose(kitchen.position[[0, 2]], position) and kitchen.yaw == yaw


def test_as_many_positions_are_reachable_as_in_unity(kitchen: Thor) -> None:
    many = len(kitchen.reachable())
    assert 100 < many < 125
    kitchen.ok("TeleportFull", position=at(-1, -1.25), rotation={"x": 0, "y": 49.11111, "z": 0}, horizon=0, standing=True)
    assert len(kitchen.reachable()) == many
    turned = len(kitchen.reachable(directionsRelativeAgent=True))
    assert 100 < turned < 125 and turned != many


@pytest.mark.parametrize("x_z", [(-2.0, -2.5), (-1.0, -2.25), (-1.0, -0.5), (-2.75, -1.75), (-2.75, -1.25), (-1.0, -1.25)])
def test_unity_teleports_there(kitchen: Thor, x_z: tuple[float, float]) -> None:
    kitchen.ok("Teleport", position=at(*x_z))
    assert np.allclose(kitchen.position, xyz(at(*x_z)), atol=MM)


@pytest.mark.parametrize("z", [-3.5, 0.0])
def test_unity_does_not_teleport_into_a_counter_or_a_wall(kitchen: Thor, z: float) -> None:
    kitchen.refused("Teleport", position=at(-1.5, z))


def test_no_invisible_wall_stands_before_the_switch(kitchen: Thor) -> None:
    """The wall is at the back of the switch, x = -4.372; the agent's radius is 0.2 m."""
    kitchen.ok("Teleport", position=at(-4.0, -1.5))
    kitchen.refused("Teleport", position=at(-4.25, -1.5))


@pytest.mark.parametrize(
    ("x_y", "point", "kind"),
    [
        ((0.5, 0.5), (-0.344259053, 1.57599819, -1.49999917), "Cabinet"),
        ((0.5, 0.2), (-0.344259053, 2.2694428, -1.49999917), "Cabinet"),
        ((0.25, 0.5), (-0.59684074, 1.57599819, -1.04842007), "Fridge"),
    ],
)
def test_rays_meet_the_fronts_where_they_do_in_unity(
    kitchen: Thor, x_y: tuple[float, float], point: tuple[float, float, float], kind: str
) -> None:
    kitchen.controller.step("ChangeResolution", x=200, y=200)
    kitchen.ok("TeleportFull", position=at(-1.5, -1.5), rotation={"x": 0, "y": 90, "z": 0}, horizon=0, standing=True)
    x, y = x_y
    assert np.allclose(xyz(kitchen.ok("GetCoordinateFromRaycast", x=x, y=y).metadata["actionReturn"]), point, atol=MM)
    assert kitchen.ok("GetObjectInFrame", x=x, y=y).metadata["actionReturn"].startswith(kind)


def test_every_object_is_teleported_by_force(kitchen: Thor) -> None:
    """Unity's test puts all 66 recorded objects of the scene where they are, among them shelves and the floor."""
    before = dict(kitchen.objects)
    for name, record in before.items():
        pose = {"position": record["position"], "rotation": record["rotation"]}
        kitchen.ok("TeleportObject", objectId=name, **pose, forceAction=True, forceKinematic=True, makeUnbreakable=True)
    for name, record in kitchen.objects.items():
        assert np.allclose(xyz(record["position"]), xyz(before[name]["position"]), atol=MM), name


def test_a_shelf_leaves_its_table_by_force_only(kitchen: Thor) -> None:
    there = {"x": -3.0, "y": 0.8, "z": -1.5}
    assert not kitchen.step("TeleportObject", objectId=SHELF, position=there)
    kitchen.ok("TeleportObject", objectId=SHELF, position=there, forceAction=True)
    table = kitchen.objects[TABLE]["position"]
    kitchen.ok("TeleportObject", objectId=TABLE, position={**table, "z": table["z"] - 1}, forceAction=True, forceKinematic=True)
    assert np.allclose(xyz(kitchen.objects[SHELF]["position"]), xyz(there), atol=MM)


def test_the_ground_stays_where_the_floor_leaves(kitchen: Thor) -> None:
    before = {name: record["position"] for name, record in kitchen.objects.items() if name != FLOOR}
    kitchen.ok("TeleportObject", objectId=FLOOR, position={"x": 0, "y": -1, "z": 0}, forceAction=True)
    assert kitchen.objects[FLOOR]["position"]["y"] == -1
    for _ in range(5):
        kitchen.ok("Pass")
    assert {name: record["position"] for name, record in kitchen.objects.items() if name != FLOOR} == before
