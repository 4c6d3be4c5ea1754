"""The navigator in a grid world: it arrives, learns from failed moves, keeps its thresholds, and chooses among equal ways."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.navigation.grid import DIRECTIONS, Grid, geodesic_m, shortest_path
from ovman.navigation.navigator import PATIENCE_CELLS, Navigator, turn_towards
from tests.arms import CONFIG

PRIMITIVES = CONFIG.primitives
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


def drive(grid, start, goal, blocked=frozenset(), expires=False, limit=400, face=None, opens_after=None):
    """The outcome, the pose, the number of actions and the moves that failed of an agent that only the edges `blocked` stop."""
    navigator = Navigator(grid, PRIMITIVES, expires)
    (x, z), yaw, moved, failures = grid.centre(start), 0.0, True, []
    for count in range(limit):
        action = navigator.decide(x, z, yaw, moved, goal, face or grid.centre(goal))
        if action in (None, "Stop"):
            return action, (x, z, yaw), count, failures
        if action == "MoveAhead":
            to = x + 0.25 * math.sin(math.radians(yaw)), z + 0.25 * math.cos(math.radians(yaw))
            here, there = grid.nearest(x, z), grid.cell_at(*to)
            shut = frozenset((here, there)) in blocked and (opens_after is None or count < opens_after)
            moved = there is not None and not shut
            if moved:
                x, z = grid.centre(there)
            else:
                failures.append(frozenset((here, there)))
        else:
            moved = True
            yaw = (yaw + (30.0 if action == "RotateRight" else -30.0)) % 360.0
    return "limit", (x, z, yaw), limit, failures


cells = st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7)), min_size=2, max_size=50)


@given(cells, st.data())
def test_it_arrives_facing_its_goal_without_a_failed_move(cells, data):
    grid = grid_of(cells)
    start = data.draw(st.sampled_from(sorted(grid.cells)))
    goal = data.draw(st.sampled_from(sorted(grid.component(start))))
    face = data.draw(st.tuples(st.floats(-1, 3), st.floats(-1, 3)))
    outcome, (x, z, yaw), _, failures = drive(grid, start, goal, face=face)
    assert outcome == "Stop" and not failures
    gx, gz = grid.centre(goal)
    assert math.hypot(gx - x, gz - z) <= PRIMITIVES.stop_within_m
    if math.hypot(face[0] - x, face[1] - z) >= 1e-3:
        error = (math.degrees(math.atan2(face[0] - x, face[1] - z)) - yaw + 180) % 360 - 180
        assert abs(error) <= PRIMITIVES.heading_tolerance_deg + 1e-5


@given(cells, st.data())
def test_a_failed_edge_is_tried_once_and_a_way_around_is_found_if_there_is_one(cells, data):
    grid = grid_of(cells)
    start = data.draw(st.sampled_from(sorted(grid.cells)))
    goal = data.draw(st.sampled_from(sorted(grid.component(start))))
    edges = sorted({frozenset((c, n)) for c in grid.cells for n in grid.neighbours(c)}, key=sorted)
    blocked = frozenset(data.draw(st.sets(st.sampled_from(edges), max_size=6)) if edges else ())
    outcome, _, _, failures = drive(grid, start, goal, blocked)
    assert len(failures) == len(set(failures))
    if geodesic_m(grid, start, goal, blocked) is not None:
        assert outcome == "Stop"
    else:
        assert outcome in ("Stop", None)


def test_a_blocked_edge_is_tried_again_only_where_edges_expire():
    grid = grid_of({(i, 0) for i in range(8)})
    blocked = frozenset({frozenset(((3, 0), (4, 0)))})
    assert drive(grid, (0, 0), (7, 0), blocked, expires=False, opens_after=20)[0] is None
    outcome, _, actions, failures = drive(grid, (0, 0), (7, 0), blocked, expires=True, opens_after=20)
    assert outcome == "Stop" and len(failures) == 1 and actions > PRIMITIVES.blocked_edge_expiry


def step(navigator: Navigator, grid: Grid, cell, goal, yaw: float = NORTH, moved: bool = True) -> str | None:
    """The decision of an agent in the middle of a cell that is to face its goal."""
    return navigator.decide(*grid.centre(cell), yaw, moved, goal, grid.centre(goal))


@pytest.fixture
def ring() -> tuple[Grid, Navigator]:
    grid = grid_of(RING)
    return grid, Navigator(grid, PRIMITIVES, expires=False)


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


def test_it_stops_at_exactly_stop_within_m():
    grid = grid_of((i, 0) for i in range(9))
    primitives = PRIMITIVES.model_copy(update={"stop_within_m": 0.5})
    assert Navigator(grid, primitives, False).decide(0.5, 0.0, EAST, True, (4, 0), (1.0, 0.0)) == "Stop"
    assert Navigator(grid, primitives, False).decide(0.49, 0.0, EAST, True, (4, 0), (1.0, 0.0)) == "MoveAhead"


@pytest.mark.parametrize("yaw", [NORTH, EAST, SOUTH, WEST])
def test_in_the_cell_of_the_goal_it_turns_to_what_it_faces_though_the_centre_is_out_of_reach(yaw):
    """Where stop_within_m is below half a cell, being in the cell is enough."""
    grid = grid_of([(0, 0), (1, 0)])
    navigator = Navigator(grid, PRIMITIVES.model_copy(update={"stop_within_m": 0.05}), False)
    expected = "Stop" if yaw == EAST else "RotateRight" if yaw == NORTH else "RotateLeft"
    assert navigator.decide(0.1, 0.1, yaw, True, (0, 0), (5.0, 0.1)) == expected


def test_a_turn_blocks_no_edge_and_a_move_that_succeeds_neither():
    grid = grid_of((i, 0) for i in range(9))
    navigator = Navigator(grid, PRIMITIVES, expires=False)
    assert step(navigator, grid, (0, 0), (8, 0), NORTH) == "RotateRight"
    assert step(navigator, grid, (0, 0), (8, 0), EAST, moved=False) == "MoveAhead"
    assert step(navigator, grid, (1, 0), (8, 0), EAST) == "MoveAhead"
    assert step(navigator, grid, (1, 0), (8, 0), EAST, moved=True) == "MoveAhead"


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


@pytest.mark.parametrize(("goal", "goes_on"), [(13, True), (15, True), (16, True), (17, False)])
def test_a_path_is_kept_while_the_goal_makes_it_at_most_patience_cells_too_long(ring, goal, goes_on):
    """Clockwise it is `goal` cells to the goal, the other way 28 - `goal`: 4 more at 16, 6 more at 17."""
    grid, navigator = ring
    assert PATIENCE_CELLS == 4
    assert step(navigator, grid, RING[0], RING[13]) == "MoveAhead"
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
    """The rest of the path is shorter than any way around."""
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


def outdated(start, goal, obstacle, expires=False, opens_after=None):
    """The outcome and the pose of an agent on a grid of 12 by 12 cells, on which an obstacle of some cells stands by now."""
    grid = grid_of((i, j) for i in range(12) for j in range(12))
    shut = frozenset(frozenset((c, n)) for c in obstacle for n in grid.neighbours(c))
    navigator = Navigator(grid, PRIMITIVES, expires, outdated=True)
    (x, z), yaw, moved = grid.centre(start), 0.0, True
    for count in range(PRIMITIVES.action_budget):
        action = navigator.decide(x, z, yaw, moved, goal, grid.centre(goal))
        if action in (None, "Stop"):
            return action, (x, z)
        moved = True
        if action == "MoveAhead":
            to = grid.cell_at(x + 0.25 * math.sin(math.radians(yaw)), z + 0.25 * math.cos(math.radians(yaw)))
            moved = to is not None and (frozenset((grid.nearest(x, z), to)) not in shut or count >= (opens_after or math.inf))
            if moved:
                x, z = grid.centre(to)
        else:
            yaw = (yaw + (30.0 if action == "RotateRight" else -30.0)) % 360.0
    return "limit", (x, z)


spot = st.tuples(st.integers(0, 11), st.integers(0, 11))


@given(spot, spot, spot, st.integers(0, 5), st.integers(0, 5))
def test_on_an_outdated_grid_it_comes_next_to_its_goal_whatever_stands_there(start, goal, corner, width, depth):
    """A thing of at most 1.25 m stands anywhere, perhaps on the goal; without it the agent goes to the very cell."""
    obstacle = {(corner[0] + i, corner[1] + j) for i in range(width) for j in range(depth)} - {start}
    outcome, (x, z) = outdated(start, goal, obstacle)
    assert outcome == "Stop"
    gap_m = math.dist((x, z), grid_of(()).centre(goal))
    assert gap_m <= (0.2 if not obstacle else 1.0 + 0.25 * math.hypot(width, depth))


def test_it_goes_on_to_a_goal_whose_cell_is_taken_and_comes_as_near_as_may_be():
    grid = grid_of((i, j) for i in range(12) for j in range(12))
    taken = {(i, j) for i in range(4, 9) for j in range(4, 9)}
    shut = frozenset(frozenset((c, n)) for c in taken for n in grid.neighbours(c))
    assert drive(grid, (0, 6), (6, 6), shut)[0] is None  # before: it gives up
    outcome, at = outdated((0, 6), (6, 6), taken)
    assert outcome == "Stop" and math.dist(at, (1.5, 1.5)) <= 1.0


def test_it_waits_for_what_bars_the_only_way():
    door = {(6, j) for j in range(12)}
    outcome, at = outdated((0, 6), (11, 6), door, opens_after=100)
    assert outcome == "Stop" and math.dist(at, (2.75, 1.5)) <= 0.2
    assert outdated((0, 6), (11, 6), door)[0] == "limit"
