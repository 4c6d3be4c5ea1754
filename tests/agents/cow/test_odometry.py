"""Dead reckoning, and noticing that an action failed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.agents.cow.map import Pose, has_failed
from ovman.agents.interface import Action
from tests.agents.cow.world import CONSTANTS, PRIMITIVES, Room

STEP = PRIMITIVES.step_m, PRIMITIVES.turn_deg
MOTIONS = st.sampled_from([Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT])


def after(pose: Pose, actions) -> Pose:
    for action in actions:
        pose = pose.after(action, *STEP)
    return pose


def test_a_loop_closes():
    side = [Action.MOVE_AHEAD] * 4 + [Action.ROTATE_RIGHT] * 3
    end = after(Pose(), side * 4)
    assert (end.x, end.z) == pytest.approx((0.0, 0.0), abs=1e-12) and end.yaw_deg == 0.0


def test_unity_turns_clockwise():
    assert after(Pose(), [Action.ROTATE_RIGHT] * 3 + [Action.MOVE_AHEAD]).x == pytest.approx(0.25)


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


def test_a_step_that_changes_little_of_the_view_goes_unnoticed():
    """The threshold is CoW's own; before a far corner a step stays below it."""
    assert seems_failed(45.0, Action.MOVE_AHEAD)
