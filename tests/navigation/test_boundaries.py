"""What lies on a threshold of the grid, of A* and of the navigator, and which of several equal ways is taken."""

from __future__ import annotations

import math

import pytest

from ovman.navigation import Grid, Navigator, shortest_path
from ovman.navigation.grid import DIRECTIONS, LATTICE_TOLERANCE_M
from ovman.navigation.navigator import PATIENCE_CELLS, turn_towards
from tests.navigation.test_navigator import PRIMITIVES

NORTH, EAST, SOUTH, WEST = 0.0, 90.0, 180.0, 270.0
RING = (
    [(0, j) for j in range(2, 5)]
    + [(i, 4) for i in range(1, 11)]
    + [(10, j) for j in range(3, -1, -1)]
    + [(i, 0) for i in range(9, -1, -1)]
    + [(0, 1)]
)
"""A corridor of 28 cells around a block, clockwise from the middle of its western side, on which north is the way clockwise."""
BACKWARDS = tuple(reversed(DIRECTIONS))


def grid_of(cells) -> Grid:
    return Grid(0.25, (0.0, 0.0), frozenset(cells))


def step(navigator: Navigator, grid: Grid, cell, goal, yaw: float = NORTH, moved: bool = True) -> str | None:
    """The decision of an agent in the middle of a cell that is to face its goal."""
    return navigator.decide(*grid.centre(cell), yaw, moved, goal, grid.centre(goal))


@pytest.fixture
def ring() -> tuple[Grid, Navigator]:
    grid = grid_of(RING)
    return grid, Navigator(grid, PRIMITIVES, expires=False)


# --- grid -----------------------------------------------------------------------------------------


def test_the_grid_of_no_positions_has_the_origin_of_the_world():
    assert Grid.from_positions([], 0.25).origin == (0.0, 0.0)


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


@pytest.mark.parametrize("point", [(2.4, 3.3), (2.0, 3.0), (2.49, 3.49), (1.51, 2.51)])
def test_the_nearest_cell_is_read_off_the_lattice_and_not_searched(point):
    """Half of all calls of a run ask for it. The set of cells only has to say whether it holds one."""

    class Membership(frozenset):
        def __iter__(self):
            raise AssertionError("the cells are gone through")

    assert Grid(1.0, (0.0, 0.0), Membership([(2, 3), (3, 2), (0, 0)])).nearest(*point) == (2, 3)


def test_cells_whose_distances_differ_by_rounding_alone_tie():
    grid = Grid(0.1, (0.3, 0.0), frozenset([(0, 0), (1, 0), (9, 0)]))
    assert grid.nearest(0.35, 0.0) == (0, 0)
    assert grid.nearest(0.35 + 1e-12, 0.0) == (0, 0)
    assert grid.nearest(0.35 + 1e-5, 0.0) == (1, 0)
    assert grid.nearest(0.3 + 0.2, 0.0) == (1, 0)


@pytest.mark.parametrize("hair", [-1e-7, 1e-7])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("other", [-3.0, 0.0, 4.0])
def test_of_cells_that_are_almost_as_near_the_nearer_one_is_taken(axis, hair, other):
    """A hair beyond the middle of two cells is far more than what rounding hides, and far less than a step."""
    ends = [tuple([k, int(other)][:: 1 - 2 * axis]) for k in (-2, -1, 1, 2)]
    for near, far in ((1, 0), (2, 3)) if hair > 0 else ((0, 1), (3, 2)):
        middle = (ends[near][axis] + ends[far][axis]) / 2
        towards = 1 if ends[near][axis] > middle else -1
        point = [middle + towards * abs(hair), other][:: 1 - 2 * axis]
        assert Grid(1.0, (0.0, 0.0), frozenset(ends)).nearest(*point) == ends[near]


# --- A* -------------------------------------------------------------------------------------------


def test_of_equal_paths_the_one_is_taken_that_goes_straight_on_in_the_order_of_the_directions():
    field = grid_of((i, j) for i in range(4) for j in range(4))
    along_x_first = tuple((i, 0) for i in range(4)) + tuple((3, j) for j in range(1, 4))
    along_z_first = tuple((0, j) for j in range(4)) + tuple((i, 3) for i in range(1, 4))
    assert shortest_path(field, (0, 0), (3, 3)) == along_x_first
    assert shortest_path(field, (0, 0), (3, 3), directions=((0, 1), (1, 0), (-1, 0), (0, -1))) == along_z_first


def test_the_search_goes_deep_first_and_does_not_open_what_lies_off_the_way():
    opened = []

    class Watched(Grid):
        def neighbours(self, cell, directions=DIRECTIONS):
            opened.append(cell)
            return super().neighbours(cell, directions)

    field = Watched(0.25, (0.0, 0.0), frozenset((i, j) for i in range(-6, 7) for j in range(-6, 7)))
    for goal in ((5, 3), (-5, 3), (5, -3), (-5, -3), (0, 5), (5, 0)):
        opened.clear()
        path = shortest_path(field, (0, 0), goal)
        assert path is not None and opened == list(path[:-1])


def test_of_equal_ways_to_a_cell_the_one_found_first_stays():
    """The two ways around the corner from the start are equally long; the second one does not replace the first."""
    around = grid_of([(0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (1, 3), (2, 0), (2, 2), (2, 3)])
    way = ((2, 3), (2, 2), (1, 2), (0, 2), (0, 1), (0, 0), (1, 0), (2, 0))
    assert shortest_path(around, (2, 3), (2, 0)) == way


def test_a_cell_that_is_met_again_by_a_longer_way_does_not_end_the_search():
    """The search runs into a dead end beside the goal first and comes back to a cell that it has left."""
    maze = grid_of(
        [(0, 2), *((1, j) for j in range(3)), (2, 0), *((3, j) for j in range(3)), (4, 1), (4, 2), *((5, j) for j in range(3))]
    )
    assert shortest_path(maze, (5, 0), (1, 2)) == (
        (5, 0), (5, 1), (4, 1), (3, 1), (3, 0), (2, 0), (1, 0), (1, 1), (1, 2),
    )  # fmt: skip


# --- turns ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("yaw", [0.0, 90.0, 170.0, 190.0, 270.0, 350.0])
def test_the_shorter_turn_is_taken_across_north_too(yaw):
    for right in (15.5, 90.0, 179.0):
        assert turn_towards(yaw, (yaw + right) % 360.0, 15.0) == "RotateRight"
        assert turn_towards(yaw, (yaw - right) % 360.0, 15.0) == "RotateLeft"
    assert turn_towards(yaw, (yaw + 180.0) % 360.0, 15.0) == "RotateLeft"


@pytest.mark.parametrize("yaw", [0.0, 90.0, 350.0])
def test_the_tolerance_of_the_heading_is_inclusive(yaw):
    for sign in (-1.0, 1.0):
        assert turn_towards(yaw, (yaw + sign * 20.0) % 360.0, 20.0) is None
        assert turn_towards(yaw, (yaw + sign * 20.01) % 360.0, 20.0) is not None
    assert turn_towards(yaw, (yaw + 0.5) % 360.0, 0.0) == "RotateRight"


# --- stopping -------------------------------------------------------------------------------------


def test_it_stops_at_exactly_stop_within_m():
    grid = grid_of((i, 0) for i in range(9))
    primitives = PRIMITIVES.model_copy(update={"stop_within_m": 0.5})
    assert Navigator(grid, primitives, False).decide(0.5, 0.0, EAST, True, (4, 0), (1.0, 0.0)) == "Stop"
    assert Navigator(grid, primitives, False).decide(0.49, 0.0, EAST, True, (4, 0), (1.0, 0.0)) == "MoveAhead"


def test_both_coordinates_count_towards_the_distance_of_the_goal():
    grid = grid_of((i, j) for i in range(9) for j in range(9))
    for goal, yaw in (((0, 6), NORTH), ((6, 0), EAST)):
        assert step(Navigator(grid, PRIMITIVES, False), grid, (0, 0), goal, yaw) == "MoveAhead"


@pytest.mark.parametrize("yaw", [NORTH, EAST, SOUTH, WEST])
def test_in_the_cell_of_the_goal_it_turns_to_what_it_faces_though_the_centre_is_out_of_reach(yaw):
    """Where stop_within_m is below half a cell, being in the cell is enough."""
    grid = grid_of([(0, 0), (1, 0)])
    navigator = Navigator(grid, PRIMITIVES.model_copy(update={"stop_within_m": 0.05}), False)
    expected = "Stop" if yaw == EAST else "RotateRight" if yaw == NORTH else "RotateLeft"
    assert navigator.decide(0.1, 0.1, yaw, True, (0, 0), (5.0, 0.1)) == expected


def test_it_turns_to_a_point_just_a_millimetre_away_and_to_none_nearer():
    grid = grid_of([(0, 0)])
    navigator = Navigator(grid, PRIMITIVES, False)
    assert navigator.decide(0.0, 0.0, NORTH, True, (0, 0), (1e-3, 0.0)) == "RotateRight"
    assert navigator.decide(0.0, 0.0, NORTH, True, (0, 0), (0.99e-3, 0.0)) == "Stop"


# --- edges that are blocked -----------------------------------------------------------------------


def test_a_turn_blocks_no_edge_and_a_move_that_succeeds_neither():
    grid = grid_of((i, 0) for i in range(9))
    navigator = Navigator(grid, PRIMITIVES, expires=False)
    assert step(navigator, grid, (0, 0), (8, 0), NORTH) == "RotateRight"
    assert step(navigator, grid, (0, 0), (8, 0), EAST, moved=False) == "MoveAhead"
    assert step(navigator, grid, (1, 0), (8, 0), EAST) == "MoveAhead"
    assert step(navigator, grid, (1, 0), (8, 0), EAST, moved=True) == "MoveAhead"


def test_the_edge_that_failed_is_the_one_that_was_tried():
    """After a turn nothing is tried, so a later report of a failure says nothing of the edge before it."""
    grid = grid_of((i, 0) for i in range(9))
    navigator = Navigator(grid, PRIMITIVES, expires=False)
    assert step(navigator, grid, (0, 0), (8, 0), EAST) == "MoveAhead"
    assert step(navigator, grid, (1, 0), (8, 0), NORTH) == "RotateRight"
    assert step(navigator, grid, (1, 0), (8, 0), EAST, moved=False) == "MoveAhead"
    assert step(navigator, grid, (0, 0), (8, 0), EAST) == "MoveAhead"


def test_it_waits_for_no_edge_where_none_is_blocked():
    """The goal is on an island. A failure that is reported before anything was tried, or after that, blocks nothing."""
    grid = grid_of([(0, 0), (1, 0), (8, 0)])
    navigator = Navigator(grid, PRIMITIVES, expires=True)
    assert [step(navigator, grid, (0, 0), (8, 0), EAST, moved=False) for _ in range(3)] == [None] * 3


def test_an_edge_is_avoided_for_exactly_blocked_edge_expiry_actions():
    grid = grid_of((i, 0) for i in range(9))
    navigator = Navigator(grid, PRIMITIVES, expires=True)
    assert step(navigator, grid, (0, 0), (8, 0), EAST) == "MoveAhead"
    waited = [step(navigator, grid, (0, 0), (8, 0), EAST, moved=False) for _ in range(PRIMITIVES.blocked_edge_expiry)]
    assert waited == ["RotateLeft"] * PRIMITIVES.blocked_edge_expiry
    assert step(navigator, grid, (0, 0), (8, 0), EAST) == "MoveAhead"


def test_it_faces_the_next_cell_where_the_way_turns(ring):
    """From RING[1] the next cell is north, the one behind it north-east."""
    grid, navigator = ring
    assert step(navigator, grid, RING[1], RING[8], NORTH) == "MoveAhead"


# --- the path that is followed --------------------------------------------------------------------


@pytest.mark.parametrize(("goal", "goes_on"), [(13, True), (15, True), (16, True), (17, False)])
def test_a_path_is_kept_while_the_goal_makes_it_at_most_patience_cells_too_long(ring, goal, goes_on):
    """Clockwise it is `goal` cells to the goal, the other way 28 - `goal`: 4 more at 16, 6 more at 17."""
    grid, navigator = ring
    assert PATIENCE_CELLS == 4
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
    assert (step(navigator, grid, RING[0], RING[goal]) == "MoveAhead") is goes_on


def test_a_path_that_ends_at_the_goal_is_as_long_as_up_to_the_goal():
    """The path is longer than to the goal, to which the other way has become free."""
    for goal, goes_on in ((16, True), (17, False)):
        navigator = Navigator(grid_of(set(RING) - {RING[24]}), PRIMITIVES, expires=False)
        grid = grid_of(RING)
        assert step(navigator, grid, RING[0], RING[20]) == "MoveAhead"
        navigator.replace(grid)
        assert (step(navigator, grid, RING[0], RING[goal]) == "MoveAhead") is goes_on


def test_a_path_is_given_up_once_a_cell_of_it_is_gone(ring):
    grid, navigator = ring
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
    smaller = grid_of(set(RING) - {RING[6]})
    navigator.replace(smaller)
    assert step(navigator, smaller, RING[0], RING[13]) != "MoveAhead"
    assert step(navigator, smaller, RING[0], RING[13], SOUTH) == "MoveAhead"


@pytest.mark.parametrize("edge", [0, 5, 9])
def test_a_path_is_given_up_once_an_edge_of_it_is_blocked(ring, edge):
    """What is left of the path is shorter than any way around."""
    grid, navigator = ring
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
    a, b = RING[edge], RING[edge + 1]
    heading = math.degrees(math.atan2(b[0] - a[0], b[1] - a[1])) % 360.0
    assert step(navigator, grid, a, RING[13], heading) == "MoveAhead"
    assert step(navigator, grid, a, RING[13], heading, moved=False) != "MoveAhead"


def test_the_way_from_the_end_of_a_path_to_a_new_goal_avoids_blocked_edges(ring):
    grid, navigator = ring
    assert step(navigator, grid, RING[13], RING[16], SOUTH) == "MoveAhead"
    navigator.decide(*grid.centre(RING[13]), SOUTH, False, RING[13], grid.centre(RING[13]))
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
    assert step(navigator, grid, RING[0], RING[14], SOUTH) == "MoveAhead"


def test_the_way_from_the_end_of_a_path_to_a_new_goal_has_no_gap(ring):
    """Cell by cell to the end: each step leads to a neighbour, and a failed one is not tried again."""
    grid, navigator = ring
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
    assert step(navigator, grid, RING[0], RING[16]) == "MoveAhead"
    assert step(navigator, grid, RING[13], RING[16], WEST if RING[14][0] < RING[13][0] else SOUTH) == "MoveAhead"
    heading = math.degrees(math.atan2(RING[14][0] - RING[13][0], RING[14][1] - RING[13][1])) % 360.0
    assert step(navigator, grid, RING[13], RING[16], heading, moved=False) != "MoveAhead"


@pytest.mark.parametrize("directions", [None, DIRECTIONS, BACKWARDS, ((0, 1), (1, 0), (0, -1), (-1, 0))])
def test_of_equal_ways_the_navigator_takes_the_one_of_its_directions(directions):
    grid = grid_of((i, j) for i in range(8) for j in range(8))
    navigator = Navigator(grid, PRIMITIVES, False, directions)
    for start, goal in (((0, 0), (5, 5)), ((5, 5), (0, 0)), ((0, 5), (5, 0))):
        for yaw in (NORTH, EAST, SOUTH, WEST):
            path = shortest_path(grid, start, goal, directions=directions)
            assert path is not None
            ahead = start[0] + round(math.sin(math.radians(yaw))), start[1] + round(math.cos(math.radians(yaw)))
            fresh = Navigator(grid, PRIMITIVES, False, directions)
            assert (step(fresh, grid, start, goal, yaw) == "MoveAhead") is (ahead == path[1])
    assert step(navigator, grid, (0, 0), (0, 4), NORTH) == "MoveAhead"
    assert step(navigator, grid, (0, 0), (3, 7), NORTH) == "MoveAhead"
    path = shortest_path(grid, (0, 4), (3, 7), directions=directions)
    assert path is not None
    assert (step(navigator, grid, (0, 4), (3, 7), NORTH) == "MoveAhead") is (path[1] == (0, 5))
