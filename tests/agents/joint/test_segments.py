"""Frames vote on places before a wall, by hand and under changes of the frame of reference; pursuit follows by depth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ovman.agents.interface import Action, CameraPose, Observation, Visit
from ovman.agents.joint.agent import Pursuit
from ovman.agents.joint.segments import grid_frame, grid_votes, log_odds, vote
from tests.arms import CONFIG

CONSTANTS = CONFIG.joint
SIDE, WALL_M = 60, 4.0


def looking(depth: np.ndarray, x: float = 0.0, z: float = 0.0, yaw_deg: float = 0.0) -> Observation:
    return Observation(None, depth.astype(np.float32), CameraPose(x, 1.5, z, yaw_deg, 0.0), 90.0)


def wall(box_m: float | None = None) -> np.ndarray:
    """A wall, and before it a box in the middle of the picture."""
    depth = np.full((SIDE, SIDE), WALL_M)
    if box_m is not None:
        depth[20:40, 20:40] = box_m
    return depth


def test_a_frame_sees_through_what_is_before_a_wall_stands_at_it_and_says_nothing_of_what_is_hidden():
    places = np.array([[0.0, 1.5, z] for z in (1.0, 3.0, 4.0, 5.0, -1.0)] + [[9.0, 1.5, 1.0]])
    said = vote(places, [grid_frame(looking(wall()), CONSTANTS)], CONSTANTS)
    assert said[0].tolist() == [1, 1, 0, 0, 0, 0] and said[1].tolist() == [0, 0, 1, 0, 0, 0]
    unknown = grid_frame(looking(np.zeros((SIDE, SIDE))), CONSTANTS)
    assert not np.any(vote(places, [unknown], CONSTANTS))
    with pytest.raises(ValueError, match="reads depth"):
        grid_frame(Observation(None, None, CameraPose(0, 0, 0, 0, 0), 90.0), CONSTANTS)


@pytest.mark.parametrize("metres", [2.0, 10.0])
def test_the_tolerance_grows_with_the_distance(metres):
    tolerance = CONSTANTS.tolerance_m + CONSTANTS.tolerance_per_m * metres
    depths = [
        np.full((SIDE, SIDE), metres + off) for off in (0.9 * tolerance, 1.1 * tolerance, -0.9 * tolerance, -1.1 * tolerance)
    ]
    place = np.array([[0.0, 1.5, metres]])
    said = [vote(place, [grid_frame(looking(depth), CONSTANTS)], CONSTANTS) for depth in depths]
    assert [int(one[1, 0]) for one in said] == [1, 0, 1, 0] and [int(one[0, 0]) for one in said] == [0, 1, 0, 0]


def test_an_edge_next_to_a_place_is_no_proof_that_it_is_gone():
    # An error of one pixel puts the edge of the box beside the place that is on it.
    column = np.full((SIDE, SIDE), WALL_M)
    column[:, SIDE // 2 + 1 :] = 2.0
    said = vote(np.array([[0.001, 1.5, 2.0]]), [grid_frame(looking(column), CONSTANTS)], CONSTANTS)
    assert said[1].tolist() == [1] and said[0].tolist() == [0]


def test_votes_do_not_depend_on_where_the_world_is():
    rng = np.random.default_rng(4)
    places = np.column_stack([rng.uniform(-2, 2, 300), rng.uniform(0, 3, 300), rng.uniform(0, 6, 300)])
    depth = rng.uniform(1, 6, (SIDE, SIDE))
    here = vote(places, [grid_frame(looking(depth), CONSTANTS)], CONSTANTS)
    turned = np.column_stack([places[:, 2] + 7.0, places[:, 1], -places[:, 0] - 3.0])  # yaw 90: +z becomes +x
    there = vote(turned, [grid_frame(looking(depth, 7.0, -3.0, 90.0), CONSTANTS)], CONSTANTS)
    assert (np.mean(here != there, axis=1) < 0.01).all()
    assert here.any() and (here[0] > here[1]).any()


def test_only_the_box_that_is_gone_is_seen_through():
    with_box, without = grid_frame(looking(wall(2.0)), CONSTANTS), grid_frame(looking(wall()), CONSTANTS)
    gone = grid_votes([with_box], [without], CONSTANTS)[0]
    boxed = np.ix_(*((ticks >= 20) & (ticks < 40) for ticks in (with_box.rows, with_box.columns)))
    seen_through = gone[0] > gone[1]
    assert seen_through[boxed].all() and seen_through.sum() == seen_through[boxed].size
    alone = grid_votes([with_box], [with_box], CONSTANTS, same_tour=True)[0]
    assert not alone.any()


def test_odds_are_even_where_nothing_is_observed_and_symmetric():
    shares = np.array([0.0, 0.0, 1.0, 0.3]), np.array([0.0, 1.0, 0.0, 0.3])
    odds = log_odds(*shares, CONSTANTS.doubt)
    assert odds[0] == odds[3] == 0.0 and odds[1] == pytest.approx(-odds[2]) and odds[2] > 3


TURNS = round(360 / CONFIG.primitives.turn_deg)


def pursuit(place=(0.0, 2.5)) -> Pursuit:
    return Pursuit(Visit((looking(wall()),), None), place, CONFIG)


FAR = (0.0, 2.0 + CONSTANTS.pursuit_m + 0.5)


@pytest.mark.parametrize(
    ("thought", "box_m", "place", "is_lost"),
    [
        *(((0.0, 2.5), metres, (0.0, metres), False) for metres in (1.5, 2.0, 3.0)),
        ((0.0, 2.5), None, (0.0, 2.5), True),
        (FAR, 2.0, FAR, True),
    ],
)
def test_it_goes_to_what_is_near_where_it_is_thought_and_stands_where_the_tour_saw_through(thought, box_m, place, is_lost):
    follows = pursuit(thought)
    follows.look(looking(wall(box_m)))
    assert math.dist(follows.place, place) < 0.1 and follows.is_lost is is_lost


def test_it_looks_all_around_once_and_again_only_after_it_saw_it():
    follows = pursuit()
    follows.look(looking(wall()))
    assert not follows.is_searching
    turns = 0
    while follows.is_lost:
        assert follows.turn() is Action.ROTATE_LEFT
        turns += 1
        assert follows.is_searching == (turns < TURNS)
    assert turns == TURNS
    follows.look(looking(wall(2.0)))
    follows.look(looking(wall()))
    assert follows.is_lost and not follows.is_searching
