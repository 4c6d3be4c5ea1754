"""CoW's map: dead reckoning, scans, frontiers, paths and steering."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.agents.cow.map import Cell, Pose, Scan, VoxelMap, VoxelState, has_failed, scan
from ovman.agents.cow.planning import DIAGONAL, STRAIGHT, Paths, face, find_frontiers, steer
from ovman.agents.interface import Action
from tests.agents.cow.world import CONSTANTS, PRIMITIVES, SIDE, Room

STEP = PRIMITIVES.step_m, PRIMITIVES.turn_deg
MOTIONS = st.sampled_from([Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT])


def after(pose: Pose, actions) -> Pose:
    for action in actions:
        pose = pose.after(action, *STEP)
    return pose


@given(st.lists(MOTIONS, max_size=40))
def test_it_agrees_with_what_exact_motions_do(actions):
    room = Room(50.0, 50.0, 0.0, 100.0, 100.0)
    for action in actions:
        room.do(action)
    end = after(Pose(), actions)
    assert (end.x + 50.0, end.z + 50.0) == pytest.approx((room.x, room.z)) and end.yaw_deg == pytest.approx(room.yaw_deg)


def seems_failed(yaw_deg: float, action: Action | None) -> bool:
    """Whether an action from a given heading, None for one that does nothing, seems to have failed to a noisy camera."""
    room = Room(3.0, 2.0, yaw_deg, boxes=((1.0, 1.6, 0.0, 1.2, 3.0, 3.6), (5.0, 6.0, 0.0, 0.9, 1.0, 4.0)))
    before = room.look()[0]
    assert action is None or room.do(action)
    noise = np.random.default_rng(0).normal(0.0, 0.003, before.shape).astype(np.float32)
    return has_failed(before, room.look()[0] + noise, CONSTANTS.unchanged_depth_m)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 359.0))
def test_what_did_nothing_and_turns_are_told_apart_from_every_heading(yaw_deg):
    assert seems_failed(yaw_deg, None)
    assert not seems_failed(yaw_deg, Action.ROTATE_LEFT)


@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, 180.0, 270.0])
def test_a_step_towards_a_wall_is_noticed(yaw_deg):
    assert not seems_failed(yaw_deg, Action.MOVE_AHEAD)


NO_CELLS = np.zeros((0, 2), np.int32)


def seen(floor=(), obstacles=(), relevance=None, origin=(0.0, 0.0)) -> Scan:
    cells = np.array([*floor, *obstacles], np.int32).reshape(-1, 2)
    is_floor = np.arange(len(cells)) < len(floor)
    value = np.zeros(len(cells), np.float32) if relevance is None else np.array(relevance, np.float32)
    return Scan(cells, is_floor, value, np.array(origin), np.zeros((0, 2)))


def mapped(*scans: Scan, agent=(0, 0)) -> VoxelMap:
    known = VoxelMap(CONSTANTS)
    for one in scans:
        known.update(one, agent)
    return known


def square_of(side: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(-side, side + 1) for j in range(-side, side + 1)]


CELLS = st.lists(st.tuples(st.integers(-12, 12), st.integers(-12, 12)), max_size=150, unique=True)
SCANS = st.lists(
    st.tuples(CELLS, st.lists(st.tuples(st.integers(-12, 12), st.integers(-12, 12)), max_size=25)), min_size=1, max_size=3
)


@given(SCANS)
def test_frontiers_are_free_and_border_on_what_is_unknown(scans):
    known = mapped(*(seen(floor, obstacles) for floor, obstacles in scans))
    first_i, first_j = known.origin
    for i, j in np.argwhere(known.state > 0) + known.origin:
        beside = [known.at(cell) for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))]
        if known.at((i, j)) is VoxelState.FRONTIER:
            assert VoxelState.UNKNOWN in beside
        if known.at((i, j)) is VoxelState.FREE:
            assert VoxelState.UNKNOWN not in beside
    targets = find_frontiers(known, (0, 0), CONSTANTS)
    assert all(known.at(target) is VoxelState.FRONTIER for target in targets)
    assert [math.hypot(*t) for t in targets] == sorted(math.hypot(*t) for t in targets)
    assert len(set(targets)) == len(targets)


@given(SCANS)
def test_obstacles_and_their_four_neighbours_are_occupied_whatever_else_was_seen(scans):
    floor, obstacles = scans[-1]
    known = mapped(*(seen(f, o) for f, o in scans))
    for i, j in obstacles:
        assert all(known.at(c) is VoxelState.OCCUPIED for c in ((i, j), (i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)))
    known.update(seen(floor=square_of(14)), (0, 0))
    assert all(known.at(cell) is VoxelState.FREE for cell in obstacles), "floor that is seen again"


def test_the_arrays_grow_and_keep_what_they_had():
    known = mapped(seen(floor=square_of(2)), seen(obstacles=[(-150, 300)]), seen(obstacles=[(70, -90)]))
    assert (
        known.at((0, 0)) is VoxelState.FREE
        and known.at((-150, 301)) is VoxelState.OCCUPIED
        and known.at((70, -90)) is VoxelState.OCCUPIED
    )
    assert known.at((1000, 0)) is VoxelState.UNKNOWN
    assert list(known.states(np.array([[0, 0], [1000, 0]]))) == [VoxelState.FREE, VoxelState.UNKNOWN]


def test_the_nearest_voxel_of_interest_becomes_a_region_and_keeps_its_place():
    far, near = (9, 0), (5, 0)
    known = mapped(seen(obstacles=[far, near], relevance=[1.0, 0.0]))
    assert known.regions == (far,)
    known.update(seen(obstacles=[far, near], relevance=[0.5, 0.95]), (0, 0))
    assert known.regions == (near, far)
    known.update(seen(floor=[(2, 2)], relevance=[1.0]), (0, 0))
    assert known.regions == (near, far), "floor is no region of interest"


def test_a_visited_frontier_takes_its_neighbourhood_with_it():
    known = mapped(seen(floor=square_of(6)))
    known.visit((6, 6))
    assert known.is_visited((4, 4)) and known.is_visited((6, 4)) and not known.is_visited((3, 6))


def lengths_from_the_middle(known: VoxelMap) -> dict[Cell, float]:
    """The lengths of the shortest ways over free cells and their eight neighbours, by relaxation."""
    found, waiting = {(0, 0): 0.0}, [(0, 0)]
    while waiting:
        i, j = waiting.pop(0)
        for di, dj in product((-1, 0, 1), repeat=2):
            there, length = (i + di, j + dj), found[i, j] + (DIAGONAL if di and dj else STRAIGHT)
            if known.at(there) in (VoxelState.FREE, VoxelState.FRONTIER) and length < found.get(there, math.inf) - 1e-9:
                found[there] = length
                waiting.append(there)
    return found


@given(SCANS)
def test_ways_over_free_cells_are_the_shortest_and_there_is_none_where_none_leads(scans):
    known = mapped(seen(floor=square_of(7)), *(seen(floor, obstacles) for floor, obstacles in scans))
    paths, lengths = Paths(known, (0, 0)), lengths_from_the_middle(known)
    for goal in product(range(-13, 14), repeat=2):
        way = paths.to(goal)
        assert (way is None) == (goal not in lengths)
        if way is not None:
            assert (way[0], way[-1]) == ((0, 0), goal) and {*way} <= {*lengths}
            steps = [(abs(a[0] - b[0]), abs(a[1] - b[1])) for a, b in pairwise(way)]
            assert all(max(step) == 1 for step in steps)
            assert sum(DIAGONAL if min(step) else STRAIGHT for step in steps) == pytest.approx(lengths[goal])


POSES = st.builds(Pose, st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.integers(0, 11).map(lambda k: 30.0 * k))


@given(SCANS, POSES, st.tuples(st.integers(-12, 12), st.integers(-12, 12)))
def test_steering_enters_no_occupied_cell_and_comes_near(scans, pose, goal):
    known = mapped(*(seen(floor, obstacles) for floor, obstacles in scans))
    actions = steer(known, pose, goal, CONSTANTS, PRIMITIVES)
    if actions is None:
        return
    assert actions[-1] is Action.MOVE_AHEAD
    for action in actions:
        pose = pose.after(action, PRIMITIVES.step_m, PRIMITIVES.turn_deg)
        if action is Action.MOVE_AHEAD:
            assert known.at((round(pose.x / CONSTANTS.voxel_m), round(pose.z / CONSTANTS.voxel_m))) is not VoxelState.OCCUPIED
    assert math.hypot(pose.x / CONSTANTS.voxel_m - goal[0], pose.z / CONSTANTS.voxel_m - goal[1]) <= CONSTANTS.waypoint_voxels


def test_steering_does_not_begin_with_what_has_just_failed():
    known = mapped(seen(floor=square_of(10)))
    assert steer(known, Pose(), (0, 6), CONSTANTS, PRIMITIVES) == (Action.MOVE_AHEAD, Action.MOVE_AHEAD)
    around = steer(known, Pose(), (0, 6), CONSTANTS, PRIMITIVES, Action.MOVE_AHEAD)
    assert around is not None and around[0] is not Action.MOVE_AHEAD


@given(POSES, st.tuples(st.integers(-9, 9), st.integers(-9, 9)).filter(lambda c: max(map(abs, c)) > 4))
def test_facing_looks_within_half_a_turn(pose, target):
    for action in face(pose, target, CONSTANTS, PRIMITIVES):
        pose = pose.after(action, PRIMITIVES.step_m, PRIMITIVES.turn_deg)
    bearing = math.degrees(math.atan2(target[0] * CONSTANTS.voxel_m - pose.x, target[1] * CONSTANTS.voxel_m - pose.z))
    assert abs((bearing - pose.yaw_deg + 180.0) % 360.0 - 180.0) <= 15.0 + 1e-6


def test_a_scan_knows_floor_from_obstacles_and_leaves_the_ceiling_out():
    room = Room(4.0, 1.0, 0.0, boxes=((3.5, 4.5, 0.0, 0.7, 3.0, 3.5),))
    points = scan(room.look()[0], np.zeros((SIDE, SIDE), np.float32), Pose(), 90.0, CONSTANTS)
    ahead = {tuple(cell) for cell in points.cells[~points.floor]}
    assert (0, 16) in ahead, "the front of the box, 2 m ahead"
    known = VoxelMap(CONSTANTS)
    known.update(points, (0, 0))
    assert known.at((0, 0)) is VoxelState.FRONTIER and known.at((0, 3)) is VoxelState.FREE, (
        "the floor that the camera does not see"
    )
    assert known.at((0, 16)) is VoxelState.OCCUPIED and known.at((0, 30)) is not VoxelState.FREE
