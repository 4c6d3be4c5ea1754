"""Driven in a plain grid world, the navigator arrives, faces what it was told to face, and learns from failed moves."""

from __future__ import annotations

import math
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from ovman.navigation.grid import Grid, geodesic_m
from ovman.navigation.navigator import Navigator
from ovman.settings.config import load

PRIMITIVES = load(Path(__file__).parents[2] / "config.yaml").primitives


def grid_of(cells: set[tuple[int, int]]) -> Grid:
    return Grid.from_positions([(0.25 * i, 0.25 * j) for i, j in cells], 0.25)


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
