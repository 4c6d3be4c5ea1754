"""The grid of reachable positions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.navigation.grid import LATTICE_TOLERANCE_M, Grid

STEP = 0.25
CELLS = st.frozensets(st.tuples(st.integers(-5, 5), st.integers(-5, 5)), min_size=1, max_size=60)
OFFSETS = st.sampled_from([0.0, 0.05, 0.1, 0.125, -0.0625, -0.1])
POINTS = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


def positions(cells, offset=(0.0, 0.0)):
    return [(offset[0] + STEP * i, offset[1] + STEP * j) for i, j in cells]


@given(CELLS, OFFSETS, OFFSETS, st.integers(0, 2**32 - 1))
def test_positions_come_back_as_centres_in_any_order_and_precision(cells, offset_x, offset_z, seed):
    points = positions(cells, (offset_x, offset_z))
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, 1e-7, len(points))
    rough = [(float(np.float32(x)) + e, float(np.float32(z)) - e) for (x, z), e in zip(points, noise, strict=True)]
    rng.shuffle(rough)
    grid, exact = Grid.from_positions(rough, STEP), Grid.from_positions(points, STEP)
    assert grid == exact
    assert len(grid.cells) == len(cells)
    centres = sorted(grid.centre(cell) for cell in grid.cells)
    assert np.allclose(centres, sorted(points), atol=1e-4)


@given(CELLS, CELLS, OFFSETS, OFFSETS)
def test_grids_of_one_lattice_share_their_indices(before, after, offset_x, offset_z):
    grids = [Grid.from_positions(positions(cells, (offset_x, offset_z)), STEP) for cells in (before, after)]
    assert grids[0].origin == grids[1].origin
    assert grids[0].cells & grids[1].cells == Grid.from_positions(positions(before & after, (offset_x, offset_z)), STEP).cells


def test_heights_are_passed_over_and_no_positions_are_no_cells():
    points = [(0.0, 0.9, 1.0), (0.25, 0.9, 1.0)]
    assert Grid.from_positions(points, STEP) == Grid.from_positions([(x, z) for x, _, z in points], STEP)
    empty = Grid.from_positions([], STEP)
    assert empty.cells == frozenset() and empty.components() == ()
    with pytest.raises(ValueError, match="empty"):
        empty.nearest(0.0, 0.0)
    with pytest.raises(ValueError, match="not one of the 1 cells"):
        Grid(STEP, (0.0, 0.0), frozenset([(0, 0)])).component((3, 3))


@given(CELLS, st.one_of(POINTS, st.tuples(*2 * [st.integers(-12, 12).map(lambda k: k / 8)])), st.data())
def test_nearest_is_nearest_and_ties_go_to_the_smallest_cell(cells, point, data):
    """Points on a lattice of half cells tie, exactly or but for rounding."""
    offset = data.draw(st.sampled_from([0.1, 0.0]))
    grid = Grid(STEP, (offset, -offset / 2), cells)
    within = data.draw(st.one_of(st.none(), st.sets(st.sampled_from(sorted(cells)), min_size=1)))
    squared = {c: ((c[0] - (point[0] - offset) / STEP) ** 2 + (c[1] - (point[1] + offset / 2) / STEP) ** 2) for c in cells}
    expected = min(cells if within is None else within, key=lambda cell: (round(squared[cell], 9), cell))
    assert grid.nearest(*point, within=within) == expected


@given(CELLS, POINTS)
def test_the_cell_at_a_point_is_the_square_around_it(cells, point):
    grid = Grid(STEP, (0.0, 0.0), cells)
    cell = grid.cell_at(*point)
    around = [c for c in cells if max(abs(p - q) for p, q in zip(grid.centre(c), point, strict=True)) <= STEP / 2 - 1e-9]
    assert around in ([], [cell])
    if cell is not None:
        assert cell in cells
        assert max(abs(p - q) for p, q in zip(grid.centre(cell), point, strict=True)) <= STEP / 2 + 1e-9
        assert grid.nearest(*point) == cell


@given(CELLS)
def test_components_partition_the_grid_into_closed_connected_sets(cells):
    grid = Grid(STEP, (0.0, 0.0), cells)
    components = grid.components()
    assert sorted(cell for component in components for cell in component) == sorted(cells)
    assert [len(c) for c in components] == sorted((len(c) for c in components), reverse=True)
    for component in components:
        for cell in component:
            assert grid.component(cell) == component
            assert set(grid.neighbours(cell)) <= component


@pytest.mark.parametrize("axis", [0, 1])
def test_a_position_at_the_tolerance_is_on_the_lattice(axis):
    off = [0.0, 0.0]
    off[axis] = LATTICE_TOLERANCE_M
    assert Grid.from_positions([(-1.0, -1.0), tuple(off)], 1.0).cells == {(-1, -1), (0, 0)}
    off[axis] = 1.01 * LATTICE_TOLERANCE_M
    with pytest.raises(ValueError, match="off the lattice"):
        Grid.from_positions([(-1.0, -1.0), tuple(off)], 1.0)


@pytest.mark.parametrize("offset", [-0.12, -0.1, -0.09, -0.05, 0.05, 0.12, 0.125])
def test_the_origin_of_a_lattice_is_its_point_in_the_cell_around_the_worlds_origin(offset):
    """On the border, half a step away, the positive point is taken."""
    for positions in ([(offset, 1.0 + offset)], [(offset - 0.25, offset + 0.5)]):
        assert Grid.from_positions(positions, 0.25).origin == pytest.approx((offset, offset))
    assert Grid.from_positions([(-0.125, -0.125)], 0.25).origin == (0.125, 0.125)


def test_cells_whose_distances_differ_by_rounding_alone_tie():
    grid = Grid(0.1, (0.3, 0.0), frozenset([(0, 0), (1, 0), (9, 0)]))
    assert grid.nearest(0.35, 0.0) == (0, 0)
    assert grid.nearest(0.35 + 1e-12, 0.0) == (0, 0)
    assert grid.nearest(0.35 + 1e-5, 0.0) == (1, 0)
    assert grid.nearest(0.3 + 0.2, 0.0) == (1, 0)
