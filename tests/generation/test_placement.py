"""Proposed places are free, far enough, and leave the tour its waypoints; candidates are a function of scene and seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.generation.candidates import eligible, targets
from ovman.generation.placement import FreeFloor, floor_spots, lanes, surface_spots


def thing(name, category, x, z, size=(0.4, 0.8, 0.4), y=None, moveable=True):
    return {
        "id": name,
        "category": category,
        "moveable": moveable,
        "pickupable": False,
        "receptacle": False,
        "position": {"x": x, "y": size[1] / 2 if y is None else y, "z": z},
        "size": dict(zip("xyz", size, strict=True)),
        "parents": [],
    }


@pytest.fixture(scope="module")
def scene():
    hole = {(i, j) for i in range(6, 10) for j in range(6, 10)}
    cells = [(i, j) for i in range(20) for j in range(16) if (i, j) not in hole]
    return {
        "scene": "Room",
        "floor_y": 0.0,
        "reachable": [[0.25 * i, 0.25 * j] for i, j in cells],
        "waypoints": [{"x": 0.5, "z": 0.5}, {"x": 4.0, "z": 3.0}],
        "objects": [
            thing("chair|1", "Chair", 1.0, 1.0),
            thing("chair|2", "Chair", 4.0, 1.0),
            thing("table|1", "DiningTable", 2.0, 2.0, (1.0, 0.7, 1.0)),
            thing("vase|1", "Vase", 2.0, 2.0, (0.2, 0.3, 0.2), y=0.85),
            thing("lamp|1", "FloorLamp", 3.0, 3.0, moveable=False),
        ],
    }


def reach(scene):
    return {(round(x / 0.25), round(z / 0.25)) for x, z in scene["reachable"]}


@settings(derandomize=True, max_examples=40, deadline=None)
@given(st.floats(0, 5), st.floats(0, 4), st.floats(0.05, 0.8), st.floats(0.05, 0.8))
def test_what_fits_blocks_no_unreachable_point_and_no_waypoint(scene, x, z, half_x, half_z):
    floor = FreeFloor.of(scene, 0.25)
    gap = {c: np.hypot(max(abs(c[0] * 0.25 - x) - half_x, 0), max(abs(c[1] * 0.25 - z) - half_z, 0)) for c in np.ndindex(30, 30)}
    blocked = {c for c, g in gap.items() if g < 0.2}
    if floor.fits(x, z, half_x, half_z):
        assert blocked <= reach(scene)
        assert not blocked & {(2, 2), (16, 12)}
    elif all(np.hypot(max(abs(w[0] - x) - half_x, 0), max(abs(w[1] - z) - half_z, 0)) > 0.3 for w in ((0.5, 0.5), (4.0, 3.0))):
        outside = x - half_x < 0.2 or z - half_z < 0.2
        assert outside or not blocked <= reach(scene)


def test_floor_spots_are_far_enough_and_fit(scene):
    floor, item = FreeFloor.of(scene, 0.25), scene["objects"][0]
    found = floor_spots(scene, item, floor, 1.5, np.random.default_rng(0))
    assert len(found) > 20
    for spot in found:
        assert np.hypot(spot.x - 1.0, spot.z - 1.0) >= 1.5
        assert floor.fits(spot.x, spot.z, 0.2, 0.2)


def test_small_things_go_on_furniture_clear_of_what_stands_there(scene):
    lamp = thing("lamp|2", "DeskLamp", 4.5, 3.5, (0.2, 0.4, 0.2))
    found = surface_spots(scene, lamp, 1.5, np.random.default_rng(0))
    assert found and all(abs(s.x - 2.0) <= 0.4 and abs(s.z - 2.0) <= 0.4 and s.height_m == pytest.approx(0.75) for s in found)
    assert all(max(abs(s.x - 2.0), abs(s.z - 2.0)) > 0.2 for s in found)
    assert (
        surface_spots(scene, scene["objects"][0] | {"size": {"x": 0.8, "y": 1.0, "z": 0.8}}, 1.5, np.random.default_rng(0)) == []
    )


def test_a_mover_fits_everywhere_on_its_lane(scene):
    floor, item = FreeFloor.of(scene, 0.25), scene["objects"][0]
    found = lanes(item, floor, 2.0)
    assert found
    for lane in found:
        assert lane.length_m >= 2.0
        assert all(floor.fits(*lane.at(a), 0.2, 0.2) for a in np.arange(0, lane.length_m, 0.25))


def test_only_categories_with_two_movable_instances_are_eligible_and_each_instance_comes_once_per_turn(scene):
    by_category = eligible(scene)
    assert list(by_category) == ["Chair"]
    drawn = [item["id"] for item, _ in zip(targets(by_category, np.random.default_rng(0)), range(4), strict=False)]
    assert sorted(drawn[:2]) == sorted(drawn[2:]) == ["chair|1", "chair|2"]
