"""Proposed places are free, far enough, and leave the tour its waypoints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.placement import (
    ABOVE_SURFACE_M,
    CLEARANCE_M,
    FLUSH_M,
    JITTER_M,
    LARGEST_ON_SURFACE_M,
    FreeFloor,
    floor_spots,
    put,
    surface_spots,
)
from ovman.records.geometry import Position
from ovman.records.scene import Scene, SceneObject
from ovman.sim.world import AGENT_RADIUS_M


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


def room(*objects, cells=12) -> Scene:
    """An empty room of so many cells of 0.25 m a side."""
    return scene_of(objects, [(0.25 * i, 0.25 * j) for i in range(cells) for j in range(cells)])


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


@given(st.floats(-0.5, 5.5), st.floats(-0.5, 4.5), st.floats(0.05, 0.8), st.floats(0.05, 0.8))
def test_what_fits_meets_no_box_no_waypoint_and_stays_near_the_reachable(scene, x, z, half_x, half_z):
    item = thing("new", "Chair", 9.0, 9.0, (2 * half_x, 0.8, 2 * half_z))
    if not FreeFloor.of(scene, item, 0.25, scene.waypoints).fits(np.array([[x, z]]))[0]:
        return
    for other in scene.objects:
        apart_x = abs(other.position.x - x) - half_x - other.size.x / 2
        apart_z = abs(other.position.z - z) - half_z - other.size.z / 2
        assert max(apart_x, apart_z) > 0 or other.position.y - other.size.y / 2 >= 0.8
    for waypoint_x, waypoint_z in scene.waypoints:
        assert np.hypot(max(abs(waypoint_x - x) - half_x, 0), max(abs(waypoint_z - z) - half_z, 0)) > 0.2
    assert x - half_x >= -0.4 and x + half_x <= 4.75 + 0.4 and z - half_z >= -0.4 and z + half_z <= 3.75 + 0.4


# --- where a thing just fits; boxes without extent make the distances exact -------------------------

STEP = 0.25
POINT = (0.0, 0.8, 0.0)
FAR = 99.0


def beyond(metres: float) -> float:
    return float(np.nextafter(metres, FAR))


def floor_of(scene, item, **changes) -> FreeFloor:
    return replace(FreeFloor.of(scene, item, STEP, scene.waypoints), **changes)


def alone(*others, **changes) -> FreeFloor:
    """The floor for a thing without extent, of a room whose only waypoint is far away."""
    item = thing("new", "Chair", FAR, FAR, POINT)
    return floor_of(room(item, *others), item, **({"waypoints": np.array([[FAR, FAR]])} | changes))


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_box_is_cleared_by_more_than_the_clearance(axis, sign):
    floor = alone(thing("box", "Chair", 0.0, 0.0, POINT))
    at, past = np.zeros((2, 2))
    at[axis], past[axis] = sign * CLEARANCE_M, sign * beyond(CLEARANCE_M)
    assert floor.fits(np.array([at, past])).tolist() == [False, True]


def test_a_waypoint_is_left_free_for_the_agent():
    radius_m = AGENT_RADIUS_M + STEP / 4
    floor = alone(waypoints=np.array([[FAR, FAR], [0.0, 0.0]]))
    points = [(radius_m, 0.0), (beyond(radius_m), 0.0), (0.0, radius_m), (0.0, beyond(radius_m))]
    assert floor.fits(np.array(points)).tolist() == [False, True, False, True]
    wide = alone(waypoints=np.array([[0.0, 0.0]]), half=np.array([0.5, 0.0]))
    assert not wide.fits(np.array([[0.5 + radius_m, 1.0], [0.5, radius_m]])).all()
    assert wide.fits(np.array([[1.0, 1.01 * radius_m]])).all()


def test_every_corner_stays_where_the_agent_can_reach():
    radius_m = AGENT_RADIUS_M + STEP / 2
    floor = alone(cells=np.array([[0.0, 0.0]]))
    points = [(radius_m, 0.0), (beyond(radius_m), 0.0), (0.0, -radius_m), (0.0, -beyond(radius_m))]
    assert floor.fits(np.array(points)).tolist() == [True, False, True, False]
    wide = alone(cells=np.array([[-0.5, 0.0], [0.5, 0.0]]), half=np.array([0.5, 0.0]))
    assert wide.fits(np.array([[0.0, 0.0], [0.9 * radius_m, 0.0], [1.1 * radius_m, 0.0]])).tolist() == [True, True, False]


def test_what_begins_at_the_top_of_a_thing_or_above_is_no_obstacle_unless_it_is_a_slab():
    item = thing("new", "Chair", FAR, FAR, (0.4, 1.0, 0.4))
    shelf = thing("shelf", "Shelf", 1.0, 1.0, (0.4, 0.5, 0.2), y=1.25)
    lower = thing("lower", "Shelf", 1.0, 1.0, (0.4, 0.5, 0.2), y=1.249)
    slab = thing("slab", "CounterTop", 2.0, 1.0, (0.4, 0.1, 0.6), y=3.0)
    ground = thing("floor", "Floor", 2.0, 2.0, (9.0, 0.1, 9.0), y=-0.05)
    assert len(FreeFloor.of(room(item, shelf, ground), item, STEP, ()).boxes) == 0
    assert FreeFloor.of(room(item, lower, ground, slab), item, STEP, ()).boxes.tolist() == [
        [1.0, 1.0, 0.2, 0.1],
        [2.0, 1.0, 0.2, 0.3],
    ]
    raised = room(item, shelf).model_copy(update={"floor_y": 0.01})
    assert len(FreeFloor.of(raised, item, STEP, raised.waypoints).boxes) == 1


def test_floor_spots_begin_at_the_distance_and_lie_within_the_jitter_of_a_cell():
    item = thing("a", "Chair", 0.0, 0.0, POINT)
    scene = room(item).model_copy(update={"floor_y": 0.123456})
    floor = floor_of(scene, item, waypoints=np.array([[FAR, FAR]]))
    found = floor_spots(scene, item, floor, 0.0, np.random.default_rng(0))
    assert len(found) == len(floor.cells)
    assert {(round(s.x / STEP), round(s.z / STEP)) for s in found} == {(round(x / STEP), round(z / STEP)) for x, z in floor.cells}
    off = [c - STEP * round(c / STEP) for s in found for c in (s.x, s.z)]
    assert -JITTER_M - 1e-3 < min(off) < -0.8 * JITTER_M and 0.8 * JITTER_M < max(off) < JITTER_M + 1e-3
    assert {s.height_m for s in found} == {round(0.123456 + ABOVE_SURFACE_M, 4)}
    assert all(round(c, 3) == c for s in found for c in (s.x, s.z))
    farthest = max(float(np.hypot(s.x, s.z)) for s in found)
    exactly = floor_spots(scene, item, floor, farthest, np.random.default_rng(0))
    assert [float(np.hypot(s.x, s.z)) for s in exactly] == [farthest]
    assert floor_spots(scene, item, floor, beyond(farthest), np.random.default_rng(0)) == []
    assert [s.x for s in found] != sorted(s.x for s in found)


def table(width=1.0, **place):
    return thing("table", "DiningTable", place.get("x", 1.0), place.get("z", 1.0), (width, 0.7, width))


def test_a_thing_of_the_largest_width_goes_on_furniture_and_a_wider_one_does_not():
    for size, fits in ((LARGEST_ON_SURFACE_M, True), (beyond(LARGEST_ON_SURFACE_M), False)):
        for shape in ((size, 0.1, 0.1), (0.1, 0.1, size)):
            item = thing("a", "Vase", FAR, FAR, shape)
            assert bool(surface_spots(room(item, table()), item, 0.5, np.random.default_rng(0))) is fits


def test_furniture_carries_what_is_smaller_than_its_top_on_both_sides():
    rng = np.random.default_rng(0)
    item = thing("a", "Vase", FAR, FAR, (0.2, 0.3, 0.2))
    assert surface_spots(room(item, table(0.2)), item, 0.5, rng) == []
    narrow = thing("table", "DiningTable", 1.0, 1.0, (1.0, 0.7, 0.2))
    assert surface_spots(room(item, narrow), item, 0.5, rng) == []
    assert surface_spots(room(item, narrow.model_copy(update={"size": Position(x=0.2, y=0.7, z=1.0)})), item, 0.5, rng) == []
    (spot,) = surface_spots(room(item, table(0.21)), item, 0.5, rng)
    assert (spot.x, spot.z) == (pytest.approx(1.0, abs=0.006), pytest.approx(1.0, abs=0.006))
    assert spot.height_m == round(0.7 + ABOVE_SURFACE_M, 4)
    no_carrier = thing("shelf", "Shelf", 1.0, 1.0, (1.0, 0.7, 1.0))
    assert surface_spots(room(item, no_carrier), item, 0.5, rng) == []


def test_what_is_put_somewhere_stands_on_the_height_that_it_is_let_down_from_and_nothing_else_moves():
    item, other = thing("a", "Vase", 1.0, 1.0, (0.2, 0.3, 0.4)), table()
    made = put(room(item, other), item, (2.0, 0.5), 0.75)
    there = made.objects[0].position
    assert (there.x, there.y, there.z) == (2.0, 0.75 + 0.15, 0.5)
    assert made.objects == (item.model_copy(update={"position": there}), other) and made.reachable == room().reachable


@pytest.mark.parametrize(
    ("size", "y", "clears"),
    [
        ((1.0, 0.1, 1.0), 0.75, False),
        ((1.0, 0.5, 1.0), 1.25, False),  # its bottom is where the thing ends
        ((1.0, 0.5, 1.0), beyond(1.25), True),
        ((1.0, 0.0, 1.0), 0.7 - FLUSH_M, False),
        ((1.0, 0.0, 1.0), float(np.nextafter(0.7 - FLUSH_M, 0.0)), True),
    ],
)
def test_a_thing_clears_what_is_above_or_let_into_the_surface(size, y, clears):
    """A thing of 0.2 x 0.3 x 0.2 m on a table whose top is 0.7 m high and covered."""
    item, other = thing("a", "Vase", FAR, FAR, (0.2, 0.3, 0.2)), thing("o", "Cup", 1.0, 1.0, size, y=y)
    assert bool(surface_spots(room(item, table(), other), item, 0.5, np.random.default_rng(0))) is clears


@pytest.mark.parametrize("axis", [0, 1])
def test_a_thing_clears_what_is_beside_it(axis):
    """Something 0.3 m wide stands across the middle of the table."""
    item, other = (
        thing("a", "Vase", FAR, FAR, (0.2, 0.3, 0.2)),
        thing("o", "Cup", 1.0, 1.0, ((0.3, 0.1, 1.0), (1.0, 0.1, 0.3))[axis]),
    )
    scene = room(item, table(), other.moved_to(y=0.75))
    spots = [spot for seed in range(20) for spot in surface_spots(scene, item, 0.5, np.random.default_rng(seed))]
    off_m = [abs((spot.x, spot.z)[axis] - 1.0) for spot in spots]
    assert len(off_m) > 10 and 0.25 < min(off_m) < 0.27
