"""What is written out for speed gives what the plain definition gives, ties and order included."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from ovman.navigation.grid import Cell, Grid

cells = st.sets(st.tuples(st.integers(-6, 6), st.integers(-6, 6)), min_size=1, max_size=80)
places = st.one_of(st.floats(-3.0, 3.0), st.integers(-24, 24).map(lambda n: n / 8), st.floats(-1e9, 1e9))


@given(cells, places, places)
def test_the_nearest_cell_is_that_of_the_rounded_distances(found: set[Cell], x: float, z: float) -> None:
    grid = Grid(0.25, (0.0, 0.0), frozenset(found))
    u, v = x / 0.25, z / 0.25
    slow = min(found, key=lambda cell: (round((cell[0] - u) ** 2 + (cell[1] - v) ** 2, 9), cell))
    assert grid.nearest(x, z) == slow


@given(cells)
def test_a_component_is_reached_in_the_order_of_the_directions(found: set[Cell]) -> None:
    grid, start = Grid(0.25, (0.0, 0.0), frozenset(found)), min(found)
    reached, queue = {start}, [start]
    while queue:
        for neighbour in grid.neighbours(queue.pop(0)):
            if neighbour not in reached:
                reached.add(neighbour)
                queue.append(neighbour)
    assert list(grid.component(start)) == list(frozenset(reached))
