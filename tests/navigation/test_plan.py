"""Shortest paths and farthest-point waypoints, against Dijkstra on the same graph."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from ovman.navigation.grid import DIRECTIONS, Grid, farthest_points, geodesic_m, shortest_path, steps_from

STEP = 0.25


@st.composite
def grids(draw):
    """Rooms of up to 9 x 9 cells with furniture in them."""
    width, depth = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    free = draw(st.lists(st.sampled_from([True, True, False]), min_size=width * depth, max_size=width * depth))
    cells = frozenset(cell for cell, is_free in zip(itertools.product(range(width), range(depth)), free, strict=True) if is_free)
    assume(cells)
    return Grid(STEP, (0.1, -0.2), cells)


def edges(grid):
    """Pairs of cells that are one step apart, by definition."""
    return [
        frozenset((a, b)) for a, b in itertools.combinations(sorted(grid.cells), 2) if abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1
    ]


def blocked_edges(data, grid):
    all_edges = edges(grid)
    return frozenset(data.draw(st.lists(st.sampled_from(all_edges), max_size=8))) if all_edges else frozenset()


def dijkstra_m(grid, start, blocked=frozenset()):
    """Distances in metres from a cell to all others, by scipy."""
    cells = sorted(grid.cells)
    index = {cell: k for k, cell in enumerate(cells)}
    matrix = np.zeros((len(cells), len(cells)))
    for a, b in map(tuple, edges(grid)):
        if frozenset((a, b)) not in blocked:
            matrix[index[a], index[b]] = matrix[index[b], index[a]] = STEP
    return dict(zip(cells, dijkstra(csr_array(matrix), indices=index[start]), strict=True))


@given(grids(), st.data())
def test_the_geodesic_is_dijkstras(grid, data):
    start = data.draw(st.sampled_from(sorted(grid.cells)))
    blocked = blocked_edges(data, grid)
    for goal, expected in dijkstra_m(grid, start, blocked).items():
        length = geodesic_m(grid, start, goal, blocked)
        assert length is None if np.isinf(expected) else length == pytest.approx(expected)
    if not blocked:
        reached = {cell: STEP * steps for cell, steps in steps_from(grid, start).items()}
        assert reached == pytest.approx({c: d for c, d in dijkstra_m(grid, start).items() if np.isfinite(d)})


@given(grids(), st.data(), st.permutations(DIRECTIONS))
def test_a_path_joins_its_ends_over_unblocked_edges_without_a_loop(grid, data, directions):
    start, goal = (data.draw(st.sampled_from(sorted(grid.cells))) for _ in range(2))
    blocked = blocked_edges(data, grid)
    path = shortest_path(grid, start, goal, blocked, tuple(directions))
    if path is None:
        assert goal not in {cell for cell, d in dijkstra_m(grid, start, blocked).items() if np.isfinite(d)}
        return
    assert (path[0], path[-1]) == (start, goal)
    assert len(set(path)) == len(path)
    for a, b in itertools.pairwise(path):
        assert b in grid.neighbours(a)
        assert frozenset((a, b)) not in blocked
    assert STEP * (len(path) - 1) == pytest.approx(geodesic_m(grid, start, goal, blocked))


def open_room(width, depth):
    return Grid(STEP, (0.0, 0.0), frozenset(itertools.product(range(width), range(depth))))


def turns(path):
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(path)]
    return sum(a != b for a, b in itertools.pairwise(steps))


@pytest.mark.parametrize("directions", list(itertools.permutations(DIRECTIONS)))
def test_over_free_floor_a_path_turns_once(directions):
    room = open_room(8, 8)
    for goal in itertools.product(range(8), repeat=2):
        assert turns(shortest_path(room, (3, 4), goal, directions=directions)) <= 1


@pytest.mark.parametrize("ends", [((0, 0), (9, 9)), ((9, 9), (0, 0))])
def test_an_end_outside_the_grid_is_an_error(ends):
    with pytest.raises(ValueError, match=r"cell \(9, 9\)"):
        shortest_path(open_room(2, 2), *ends)


@given(grids(), st.data())
def test_each_waypoint_is_the_farthest_from_those_before(grid, data):
    component = grid.components()[0]
    first = data.draw(st.sampled_from(sorted(component)))
    count = data.draw(st.integers(1, min(6, len(component))))
    chosen = farthest_points(grid, component, count, first)
    assert chosen[0] == first and len(set(chosen)) == count and set(chosen) <= component
    distances = [dijkstra_m(grid, cell) for cell in chosen]
    for k in range(1, count):
        clearance = {cell: round(min(d[cell] for d in distances[:k]) / STEP) for cell in component}
        assert chosen[k] == min(component, key=lambda cell: (-clearance[cell], cell))
    assert farthest_points(grid, sorted(component, reverse=True), count, first) == chosen


def test_waypoints_need_a_component_that_has_them():
    room = Grid(STEP, (0.0, 0.0), frozenset([(0, 0), (0, 1), (5, 5)]))
    with pytest.raises(ValueError, match="2 cells does not have 3 waypoints"):
        farthest_points(room, room.component((0, 0)), 3, (0, 0))
    with pytest.raises(ValueError, match="first waypoint"):
        farthest_points(room, room.component((0, 0)), 1, (5, 5))
    with pytest.raises(ValueError, match=r"\(5, 5\) cannot be reached"):
        farthest_points(room, room.cells, 2, (0, 0))
