"""CoW in a room of boxes whose geometry is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ovman.agents.cow.agent import Mode
from ovman.agents.cow.map import VoxelState
from ovman.agents.interface import Action, CameraPose
from tests.agents.cow.world import CONSTANTS, NOWHERE, PRIMITIVES, Room, Sight, walked

TARGET = (6.6, 7.0, 0.3, 0.8, 4.6, 5.0)
TABLE = (3.0, 4.2, 0.0, 0.8, 2.2, 3.4)
SHELF = (5.0, 5.4, 0.0, 2.0, 3.5, 6.0)
STARTS = [(1.0, 1.0, 0.0), (2.0, 5.0, 210.0), (4.5, 1.2, 90.0)]


def room(start, *boxes) -> Room:
    return Room(*start, boxes=boxes)


@pytest.mark.parametrize("start", STARTS)
def test_it_stops_beside_what_it_detected(start):
    here, sight = room(start, TARGET, TABLE, SHELF), Sight()
    agent, actions, places = walked(here, sight, 250)
    assert actions[-1] is Action.STOP and sight.found > 0 and agent.map.regions
    assert set(actions) <= {Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT, Action.STOP}
    nearest = min(math.dist(agent.cell, region) for region in agent.map.regions) * CONSTANTS.voxel_m
    assert nearest < CONSTANTS.stop_voxels * CONSTANTS.voxel_m + PRIMITIVES.step_m
    assert here.distance() < 1.0 + PRIMITIVES.step_m
    true, thought = places[-1]
    assert math.dist(true, thought) < 1e-6


def test_a_category_that_is_not_there_costs_the_budget_and_the_room_is_explored():
    """It spins first. Free cells of its map are free in the room."""
    here = room(STARTS[0], TARGET, TABLE, SHELF)
    agent, actions, places = walked(here, Sight(None), 120)
    spin = CONSTANTS.spin_turns
    assert actions[:spin] == [Action.ROTATE_LEFT] * spin and agent.mode is Mode.EXPLORE
    assert len(actions) == 120 and Action.STOP not in actions and not agent.map.regions
    assert (np.ptp([true for true, _ in places], axis=0) > 3.0).any()
    voxel_m, free = CONSTANTS.voxel_m, np.isin(agent.map.state, (VoxelState.FREE, VoxelState.FRONTIER))
    x, z = ((np.argwhere(free) + agent.map.origin) * voxel_m + STARTS[0][:2]).T
    assert free.sum() * voxel_m**2 > 20.0
    assert (x > -voxel_m).all() and (x < here.width + voxel_m).all() and (z > -voxel_m).all() and (z < here.depth + voxel_m).all()
    for x_0, x_1, _, _, z_0, z_1 in (TABLE, SHELF):
        assert not ((x > x_0 + voxel_m) & (x < x_1 - voxel_m) & (z > z_0 + voxel_m) & (z < z_1 - voxel_m)).any()
    agent.familiarise(None)
    assert agent.pose.cell(1.0) == (0, 0) and agent.mode is Mode.SPIN and not agent.map.regions and not agent.map.state.any()


def test_equal_rooms_give_equal_walks_wherever_the_observation_says_the_camera_is():
    one = walked(room(STARTS[1], TARGET, TABLE), Sight(), 60)[1]
    other = walked(room(STARTS[1], TARGET, TABLE), Sight(), 60, CameraPose(3.0, 1.0, -2.0, 77.0, 0.0))[1]
    assert one == other == walked(room(STARTS[1], TARGET, TABLE), Sight(), 60, NOWHERE)[1]


def test_a_move_that_was_blocked_is_noticed_and_not_believed():
    # Glass: nothing in the depth image says that it is there.
    class Glass(Room):
        def fits(self, x, z):
            return super().fits(x, z) and x < 3.0

    here = Glass(2.0, 3.0, 90.0)
    _, actions, places = walked(here, Sight(None), 60)
    assert here.blocked > 0 and Action.STOP not in actions
    for action, (before, thought_before), (after, thought_after) in zip(actions, places, places[1:], strict=False):
        if action is Action.MOVE_AHEAD and before == after:
            assert thought_before == thought_after
