"""Walls inferred from floor plans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman_engine.bodies.footprint import Boxes
from ovman_engine.plan import floorplan
from ovman_engine.room.building import room_of
from ovman_engine.room.inferred import WALL_ITEMS
from ovman_engine.room.masonry import structures
from ovman_engine.room.room import Room
from ovman_engine.world.world import World

SCENES = floorplan.names()
RECORDED = Path(__file__).parents[1] / "bench" / "unity" / "recorded.npz"
"""Where agents of AI2-THOR 5.0 stood, among others"""


@pytest.fixture(scope="module")
def rooms() -> list[Room]:
    return [room_of(floorplan.load(name)) for name in SCENES]


def test_agent_bounds_lie_inside_the_walls_that_are_seen(rooms: list[Room]) -> None:
    for room in rooms:
        inner, outer = np.array(room.rectangle), np.array(room.outline)
        assert (outer[:2] <= inner[:2]).all() and (inner[2:] <= outer[2:]).all()
        assert (inner[2:] - inner[:2] > 0.5).all()


def test_start_is_inside_and_no_wall_covers_it(rooms: list[Room]) -> None:
    for room in rooms:
        start = room.plan.start[[0, 2]]
        distances = Boxes.of([w.box for w in room.walls]).distances(start[None], 0.2, 1.6, within=1.0)
        assert distances.min() > 0.05, room.plan.name


def test_what_stands_on_the_floor_stands_inside_the_walls(rooms: list[Room]) -> None:
    scenery = {("FloorPlan410", "Faucet")}  # 1.3 m outside the recorded floor
    outside = set()
    for room in rooms:
        x_0, z_0, x_1, z_1 = room.outline
        for obj in room.plan.objects:
            low, high = obj.box.bounds()
            beyond = max(x_0 - low[0], z_0 - low[2], high[0] - x_1, high[2] - z_1)
            if obj.type != "Floor" and obj.type not in WALL_ITEMS and beyond > 0.1:
                outside.add((room.plan.name, obj.type))
    assert outside == scenery


def test_no_block_swallows_what_stands_in_the_room(rooms: list[Room]) -> None:
    for room in rooms:
        for block in room.blocks:
            x_0, z_0, x_1, z_1 = block.rectangle((-50.0, -50.0, 50.0, 50.0))
            for obj in room.plan.objects:
                if obj.type != "Floor" and obj.type not in WALL_ITEMS:
                    x, _, z = obj.box.centre
                    swallowed = x_0 + 0.05 < x < x_1 - 0.05 and z_0 + 0.05 < z < z_1 - 0.05
                    assert not swallowed, (room.plan.name, obj.object_id)


def test_every_window_has_an_opening_in_each_wall_that_it_is_in(rooms: list[Room]) -> None:
    for room in rooms:
        solid = [p for name, parts, _ in structures(room) if name.startswith("wall") for p in parts if p.slot == "main"]
        low = np.array([p.centre - p.size / 2 for p in solid])
        high = np.array([p.centre + p.size / 2 for p in solid])
        for window in (o for o in room.plan.objects if o.type == "Window"):
            size = window.box.bounds()[1] - window.box.bounds()[0]
            axis = 0 if size[0] < size[2] else 2
            if size[axis] < 0.2:
                inside = (low + 1e-6 < window.box.centre) & (high - 1e-6 > window.box.centre)
                along_wall = (high - low)[:, axis] < 0.11
                assert not (inside.all(axis=1) & along_wall).any(), (room.plan.name, window.object_id)


def test_positions_of_real_agents_are_free() -> None:
    recorded = np.load(RECORDED)
    places = {
        (scene, x, z) for scene, (x, _, z) in zip(recorded["agent_scene"].tolist(), recorded["agent"].tolist(), strict=True)
    }
    worlds = {name: World(floorplan.load(name)) for name in SCENES}
    free = [worlds[scene].blocker((x, z), (x, z)) is None for scene, x, z in places]
    assert len(free) == 4818 and np.mean(free) >= 0.97
