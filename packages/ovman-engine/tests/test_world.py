"""Worlds: poses, obstacles of the agent, and changes. Physics itself: test_physics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.plan import floorplan
from ovman_engine.world.world import World

SCENES = ["FloorPlan3", "FloorPlan201", "FloorPlan215", "FloorPlan413"]
PLANS = {name: floorplan.load(name) for name in SCENES}


def named(world: World, kind: str) -> str:
    return next(name for name in world.bodies if name.startswith(kind + "|"))


def poses(world: World) -> np.ndarray:
    return np.array([np.concatenate([b.pose.position, b.pose.rotation.ravel()]) for b in world.bodies.values()])


def free_floor(world: World, index: int = 0) -> np.ndarray:
    """A reachable point away from the agent."""
    points = np.array(world.reachable())
    far = points[np.linalg.norm(points - world.agent.position, axis=1) > 1.0]
    return far[index % len(far)]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.soak] if k % 5 else []) for k, name in enumerate(floorplan.names())]
)
def test_start_is_reachable_and_free(name: str) -> None:
    world = World(floorplan.load(name))
    start = world.agent.position
    found = world.reachable()
    assert found[0] == tuple(start)
    assert len(found) > 4
    assert world.blocker(start[[0, 2]], start[[0, 2]]) is None


@pytest.mark.parametrize("name", SCENES)
def test_positions_are_reachable_exactly_if_moves_get_there(name: str) -> None:
    world = World(PLANS[name])
    found = {(round(x, 3), round(z, 3)) for x, _, z in world.reachable()}
    joined = {next(iter(found)): 0}
    for x, z in sorted(found):
        for dx, dz in ((0.25, 0), (-0.25, 0), (0, 0.25), (0, -0.25)):
            beside = (round(x + dx, 3), round(z + dz, 3))
            if world.blocker((x, z), (x + dx, z + dz)) is None:
                assert beside in found, (x, z, beside)
                joined[beside] = 1
    assert set(joined) == found


@pytest.mark.parametrize("name", SCENES)
def test_reachable_set_does_not_hang_on_where_in_it_the_agent_is(name: str) -> None:
    world = World(PLANS[name])
    found = sorted(world.reachable())
    for point in found[:: max(1, len(found) // 3)]:
        world.agent.position = np.array(point)
        assert np.allclose(sorted(world.reachable()), found)


@given(st.sampled_from(SCENES), st.integers(0, 10_000), st.floats(0, 360), st.floats(0.05, 1.0))
def test_what_blocks_a_way_blocks_it_from_both_ends(name: str, index: int, heading: float, length: float) -> None:
    world = World(PLANS[name])
    points = np.array(world.reachable())[:, [0, 2]]
    start = points[index % len(points)]
    end = start + length * np.array([np.sin(np.radians(heading)), np.cos(np.radians(heading))])
    if world.blocker(start, end) is None and world.blocker(end, end) is None:
        assert world.blocker(end, start) is None
        middle = (start + end) / 2
        assert world.blocker(start, middle) is None and world.blocker(middle, middle) is None


def test_a_body_in_the_way_blocks_and_a_disabled_one_does_not() -> None:
    world = World(PLANS["FloorPlan201"])
    chair, spot = named(world, "Chair"), free_floor(world, 20)
    world.place(chair, spot)
    spot = world.box(chair).centre[[0, 2]]
    away = spot + [0.0, 0.9]
    assert world.blocker(away, spot, ignore=()) == chair
    assert world.blocker(away, spot, ignore=(chair,)) != chair
    cells = len(world.reachable())
    world.set_active(chair, False)
    assert world.blocker(away, spot) != chair
    assert len(world.reachable()) > cells
    world.set_active(chair, True)
    assert len(world.reachable()) == cells
    world.remove(chair)
    assert world.blocker(away, spot) != chair


def test_a_body_that_comes_to_the_agent_does_not_hold_it() -> None:
    world = World(PLANS["FloorPlan215"])
    table = named(world, "CoffeeTable")
    here = world.agent.position[[0, 2]]
    low, high = world.box(table).bounds()
    shift = np.array([here[0] + 0.1 - low[0], 0.0, here[1] - (low[2] + high[2]) / 2])
    world.teleport(table, world.bodies[table].pose.position + shift, force=True, kinematic=True)
    assert world.blocker(here, here) == table
    assert world.blocker(here, here + [0.25, 0.0]) == table
    assert world.blocker(here, here - [0.25, 0.0]) != table
    assert len(world.reachable()) > 1


def test_teleporting_a_mover_wakes_nothing_and_a_carrier_takes_its_parts() -> None:
    world = World(PLANS["FloorPlan201"])
    table = "SideTable|-02.11|+00.00|-00.14"
    drawer = next(b.object_id for b in world.bodies.values() if b.carrier == table)
    offset = world.box(drawer).centre - world.box(table).centre
    for contents in [b for b in world.bodies.values() if table in b.obj.parents]:
        world.remove(contents.object_id)
    world.advance(1.0)
    for k in range(5):
        world.teleport(table, world.bodies[table].pose.position + [0.0, 0.0, 0.1], force=True, kinematic=True)
        assert world.at_rest
        assert np.allclose(world.box(drawer).centre - world.box(table).centre, offset, atol=1e-9), k
    world.set_active(table, False)
    assert not world.bodies[drawer].active
