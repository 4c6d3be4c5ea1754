"""Following what moves by depth: before a wall, with a box that was not there."""

from __future__ import annotations

import math

import pytest

from ovman.agents.interface import Action, Visit
from ovman.agents.joint.agent import Pursuit
from tests.agents.joint.test_sight import WALL_M, looking, wall
from tests.arms import CONFIG

SETTINGS = CONFIG
TURNS = round(360 / CONFIG.primitives.turn_deg)


def pursuit(place=(0.0, 2.5)) -> Pursuit:
    return Pursuit(Visit((looking(wall()),), None), place, SETTINGS)


@pytest.mark.parametrize("metres", [1.5, 2.0, 3.0])
def test_it_goes_where_something_stands_that_the_tour_saw_through(metres):
    follows = pursuit()
    follows.look(looking(wall(metres)))
    assert math.dist(follows.place, (0.0, metres)) < 0.1 and not follows.is_lost


def test_what_stood_there_before_is_not_followed():
    follows = pursuit()
    follows.look(looking(wall()))
    assert follows.place == (0.0, 2.5) and follows.is_lost


def test_what_is_too_far_from_where_it_is_thought_is_not_followed():
    far = (0.0, 2.0 + CONFIG.joint.pursuit_m + 0.5)
    follows = pursuit(far)
    follows.look(looking(wall(2.0)))
    assert follows.place == far and follows.is_lost and WALL_M > 2.0


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
