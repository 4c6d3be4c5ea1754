"""In a home of several rooms things stay in their room: records have no walls, but the corners of each floor."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path as Outline

from ovman.generation.placement import FreeFloor
from ovman.generation.roaming import roam
from ovman.generation.sight import Sight
from ovman.records.scene import Scene
from tests.generation.test_placement import scene_of, thing

ELL = ((0.0, 0.0), (0.0, 4.0), (3.0, 4.0), (3.0, 1.5), (1.5, 1.5), (1.5, 0.0))
EAST = ((3.0, 1.5), (3.0, 4.0), (6.0, 4.0), (6.0, 1.5))
STEP_M = 0.25
COORDINATE = st.integers(-40, 260).map(lambda n: (n + 0.5) / 40)
"""On no side of a room"""


def home(*objects, rooms=(ELL, EAST)) -> Scene:
    """The two rooms with cells of the agent up to 0.2 m from the wall between them, on both sides."""
    lattice = np.stack(np.meshgrid(np.arange(0.25, 6.0, STEP_M), np.arange(0.25, 4.0, STEP_M)), axis=-1).reshape(-1, 2)
    inside = scene_of((), []).model_copy(update={"rooms": (ELL, EAST)}).find_rooms(lattice) >= 0
    cells = [(x, z) for x, z in lattice[inside].tolist() if abs(x - 3.0) > 0.2]
    return scene_of(objects, cells).model_copy(update={"rooms": rooms})


@given(st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=30))
def test_a_point_is_in_the_room_whose_outline_holds_it(points):
    each = [Outline(corners).contains_points(points) for corners in (ELL, EAST)]
    assert (home().find_rooms(np.array(points)) == np.where(each[0], 0, np.where(each[1], 1, -1))).all()
    assert (home(rooms=None).find_rooms(np.array(points)) == 0).all()


@given(st.tuples(COORDINATE, COORDINATE))
def test_nothing_is_put_into_a_wall(at):
    scene = home(box := thing("Box|1", "Box", 1.0, 3.0, (0.6, 0.5, 0.6)))
    corners = np.array(at) + 0.3 * np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    if FreeFloor.of(scene, box, STEP_M, scene.waypoints).fits(np.array([at]))[0]:
        assert len({*scene.find_rooms(corners).tolist()}) == 1


def test_a_mover_next_to_a_wall_stays_on_its_side():
    chair = thing("Chair|1", "Chair", 2.75, 3.0, (0.4, 0.8, 0.4))
    through, stays = (
        roam(one, chair, FreeFloor.of(one, chair, STEP_M, one.waypoints), 0.1) for one in (home(chair, rooms=None), home(chair))
    )
    assert any(through.at(cell)[0] > 3.0 for cell in through.cells)
    assert stays.cells and all(stays.at(cell)[0] + 0.2 < 3.0 + 0.02 for cell in stays.cells)


def test_what_is_in_another_room_is_not_foreseen_to_be_seen():
    scene = home(box := thing("Box|1", "Box", 4.0, 3.0, (0.6, 0.5, 0.6)))
    at = (4.0, 0.25, 3.0)
    assert (
        Sight.of(scene, [(2.0, 3.0)]).solid_angle(box, at) == 0.0 < Sight.of(scene, [(2.0, 3.0), (5.5, 3.0)]).solid_angle(box, at)
    )
