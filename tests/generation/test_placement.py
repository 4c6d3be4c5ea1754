"""Proposed places are free, far enough, and leave the tour its waypoints; candidates are a function of scene and seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.placement import FreeFloor
from ovman.records.geometry import Position
from ovman.records.scene import Scene, SceneObject


def thing(name, category, x, z, size=(0.4, 0.8, 0.4), y=None, moveable=True):
    return SceneObject(
        id=name,
        category=category,
        moveable=moveable,
        pickupable=False,
        receptacle=False,
        position=Position(x=x, y=size[1] / 2 if y is None else y, z=z),
        size=Position(**dict(zip("xyz", size, strict=True))),
        parents=(),
    )


def scene_of(objects, reachable, waypoints=((0.0, 0.0),)) -> Scene:
    """Return a scene of these objects, and positions and waypoints in metres."""
    return Scene(
        scene="Room", start=waypoints[0], floor_y=0.0, reachable=tuple(reachable), components=(len(tuple(reachable)),),
        waypoints=waypoints, other_waypoints=waypoints, mobile=(), objects=tuple(objects),
    )  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    hole = {(i, j) for i in range(6, 10) for j in range(6, 10)}
    cells = [(i, j) for i in range(20) for j in range(16) if (i, j) not in hole]
    objects = (
        thing("chair|1", "Chair", 1.0, 1.0),
        thing("chair|2", "Chair", 4.0, 1.0),
        thing("table|1", "DiningTable", 2.0, 2.0, (1.0, 0.7, 1.0)),
        thing("vase|1", "Vase", 2.0, 2.0, (0.2, 0.3, 0.2), y=0.85),
        thing("lamp|1", "FloorLamp", 3.0, 3.0, moveable=False),
    )
    return scene_of(objects, [(0.25 * i, 0.25 * j) for i, j in cells], ((0.5, 0.5), (4.0, 3.0)))


def floor_for(scene, item):
    return FreeFloor.of(scene, item, 0.25, scene.waypoints)


@given(st.floats(-0.5, 5.5), st.floats(-0.5, 4.5), st.floats(0.05, 0.8), st.floats(0.05, 0.8))
def test_what_fits_meets_no_box_no_waypoint_and_stays_near_the_reachable(scene, x, z, half_x, half_z):
    item = thing("new", "Chair", 9.0, 9.0, (2 * half_x, 0.8, 2 * half_z))
    if not floor_for(scene, item).fits(np.array([[x, z]]))[0]:
        return
    for other in scene.objects:
        apart_x = abs(other.position.x - x) - half_x - other.size.x / 2
        apart_z = abs(other.position.z - z) - half_z - other.size.z / 2
        assert max(apart_x, apart_z) > 0 or other.position.y - other.size.y / 2 >= 0.8
    for waypoint_x, waypoint_z in scene.waypoints:
        assert np.hypot(max(abs(waypoint_x - x) - half_x, 0), max(abs(waypoint_z - z) - half_z, 0)) > 0.2
    assert x - half_x >= -0.4 and x + half_x <= 4.75 + 0.4 and z - half_z >= -0.4 and z + half_z <= 3.75 + 0.4
