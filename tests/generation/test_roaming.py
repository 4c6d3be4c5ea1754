"""Where a mover can go: over known floor alone, from where it stands, clear of others, and never with what it carries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.generation.placement import CLEARANCE_M, FreeFloor
from ovman.generation.roaming import ON_FLOOR_M, carries, roam
from ovman.records.scene import Scene
from ovman.sim.world import AGENT_RADIUS_M
from tests.episodes import scene_record
from tests.generation.test_placement import scene_of, thing

STEP_M, CELL_M = 0.1, 0.25
CHAIR = (0.4, 0.8, 0.4)


def room(item, *others, cells=14, waypoint=(0.0, 0.0)) -> Scene:
    """A room of so many cells a side, from which the agent is kept by what stands in it."""
    objects = (item, *others)
    grid = [(CELL_M * i, CELL_M * j) for i in range(cells) for j in range(cells)]

    def is_free(x: float, z: float) -> bool:
        gaps = (np.maximum(np.abs(np.subtract((x, z), o.place)) - o.half, 0) for o in objects)
        return all(np.hypot(*gap) > AGENT_RADIUS_M for gap in gaps)

    return scene_of(objects, [at for at in grid if is_free(*at)], (waypoint,))


def roamed(item, *others, **of_room):
    scene = room(item, *others, **of_room)
    return roam(scene, item, FreeFloor.of(scene, item, CELL_M, scene.waypoints), STEP_M)


def test_alone_in_a_room_it_goes_everywhere_but_to_the_waypoint_and_the_walls():
    found = roamed(thing("chair|1", "Chair", 1.6, 1.6, CHAIR))
    places = np.array([found.at(cell) for cell in found.cells])
    assert places.min() >= 0.2 - AGENT_RADIUS_M - 1e-9 and places.max() <= 3.25 + AGENT_RADIUS_M - 0.2 + 1e-9
    assert np.abs(places - 1.6).max() > 1.3
    assert (np.hypot(*np.maximum(np.abs(places) - 0.2, 0).T) > AGENT_RADIUS_M).all()


boxes = st.tuples(st.floats(0.3, 3.0), st.floats(0.3, 3.0))


@settings(derandomize=True, max_examples=15, deadline=None)
@given(boxes, st.lists(boxes, max_size=4))
def test_a_mover_that_stands_free_stays_clear_of_every_other_box(here, elsewhere):
    item = thing("chair|1", "Chair", *here, CHAIR)
    others = [thing(f"box|{k}", "Box", *at, CHAIR) for k, at in enumerate(elsewhere)]
    apart = [max(abs(o.position.x - here[0]), abs(o.position.z - here[1])) - 0.4 for o in others]
    found = roamed(item, *others)
    if found is None:
        return
    for cell in found.cells:
        x, z = found.at(cell)
        for o, least in zip(others, apart, strict=True):
            now = max(abs(o.position.x - x), abs(o.position.z - z)) - 0.4
            assert now >= min(CLEARANCE_M, least) - 2e-4


def test_a_chair_is_pulled_straight_out_from_under_a_table_and_not_through_its_legs():
    table = thing("table|1", "DiningTable", 1.6, 1.6, (1.2, 0.75, 0.8))
    found = roamed(thing("chair|1", "Chair", 1.6, 2.1, CHAIR), table, cells=18)
    assert found is not None
    under = {cell for cell in found.cells if abs(found.at(cell)[1] - 1.6) < 0.61 and abs(found.at(cell)[0] - 1.6) < 0.79}
    assert {column for column, _ in under} == {0} and {row for _, row in under} == {0, 1}
    assert roamed(thing("chair|1", "Chair", 1.6, 1.6, CHAIR), table) is None


def test_what_stands_on_furniture_or_carries_something_cannot_move():
    item = thing("table|1", "SideTable", 1.6, 1.6, CHAIR)
    lamp = thing("lamp|1", "DeskLamp", 1.6, 1.6, (0.1, 0.3, 0.1), y=0.95)
    on_it, beside = (lamp.model_copy(update={"parents": parents}) for parents in (("table|1",), ("desk|1", "table|1")))
    ground = thing("floor|1", "Floor", 1.6, 1.6, (9.0, 0.0, 9.0))
    under = thing("bin|1", "Bin", 1.6, 1.6, (0.1, 0.1, 0.1)).model_copy(update={"parents": ("table|1", "floor|1")})
    assert carries(room(item, on_it), item) and not carries(room(item, beside), item)
    assert not carries(room(item, ground, under), item)
    assert roamed(item) is not None and roamed(item, on_it) is None
    on_top = thing("vase|1", "Vase", 1.6, 1.6, CHAIR, y=0.4 + ON_FLOOR_M + 0.01)
    assert roamed(on_top) is None


@pytest.mark.parametrize("scene", ["FloorPlan7", "FloorPlan223"])
def test_in_real_scenes_the_floor_is_connected_and_the_body_is_over_what_the_agent_can_reach(scene):
    record = scene_record(scene)
    reachable = np.array(record.reachable)
    floors = {o.id: FreeFloor.of(record, o, CELL_M, record.waypoints) for o in record.objects}
    roams = {o.id: roam(record, o, floors[o.id], STEP_M) for o in record.objects if o.moveable}
    found = {k: one for k, one in roams.items() if one is not None}
    assert found and len(found) < len(roams)
    for k, one in found.items():
        (item,) = (o for o in record.objects if o.id == k)
        for cell in one.cells:
            x, z = one.at(cell)
            assert {(cell[0] + a, cell[1] + b) for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))} & one.cells
            if max(abs(x - item.position.x) - item.size.x, abs(z - item.position.z) - item.size.z) > AGENT_RADIUS_M + CELL_M:
                assert np.hypot(*(reachable - (x, z)).T).min() <= AGENT_RADIUS_M
