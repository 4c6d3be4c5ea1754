"""The layout prior: what it measures of a grid, and that it reads the noun and nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.interface import Query, Relation
from ovman.agents.layout import EDGES, describe_places, lay_lattice, predict, read_counts, split_rooms

ROOM = np.array([(0.25 * x, 0.25 * z) for x in range(17) for z in range(13)])
"""4.4 m x 3.4 m between its walls."""
TWO = np.concatenate([ROOM, ROOM + (4.5, 0.0), [(4.25, 1.5), (4.25, 1.75)]])
"""Two such rooms, with a doorway between them."""


def test_a_doorway_splits_a_grid_into_rooms():
    rooms, openings = split_rooms(ROOM)
    assert len(rooms) == 1 and not len(openings)
    rooms, openings = split_rooms(TWO)
    assert [np.round(low, 2).tolist() for low, _ in rooms] == [[-0.2, -0.2], [4.3, -0.2]]
    assert sorted(map(tuple, openings.tolist())) == [(4.25, 1.5), (4.25, 1.75)]


def test_places_are_described_by_walls_middle_openings_and_free_floor():
    by_wall, by_door = describe_places(TWO, np.array([(0.0, 1.5), (4.0, 1.5)]))
    names = list(EDGES)
    assert by_wall[names.index("wall_m")] < by_wall[names.index("middle")]
    assert by_door[names.index("opening_m")] == 0 < by_wall[names.index("opening_m")]
    assert by_wall[names.index("free_m")] == 0
    # A thing that stands on the grid leaves a hole in it.
    hole = ROOM[np.hypot(*(ROOM - (2.0, 1.5)).T) > 0.7]
    assert describe_places(hole, np.array([(2.0, 1.5)]))[0, names.index("free_m")] > 0


@pytest.mark.parametrize("grid", [ROOM, TWO, ROOM[:1]])
def test_an_answer_is_a_place_of_the_lattice_that_follows_from_the_noun_alone(grid):
    lattice = {tuple(place) for place in lay_lattice(grid).tolist()}
    for category in (*read_counts()["categories"], "Unheard"):
        found = {predict(Query(category, relation), SimpleNamespace(grid=grid))[0] for relation in Relation}
        assert len(found) == 1 and {(one.x, one.z) for one in found} <= lattice


def test_things_that_stand_at_walls_are_looked_for_at_walls():
    def from_wall(category):
        found = predict(Query(category, Relation.MOVED), SimpleNamespace(grid=ROOM))[0]
        return min(found.x + 0.2, 4.2 - found.x, found.z + 0.2, 3.2 - found.z)

    assert from_wall("ShelvingUnit") < 0.75 < from_wall("DogBed")
