"""The yaw of the agent's start."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.plan import floorplan
from ovman_engine.plan.facing import AHEAD, YAWS_DEG, open_yaw, seen_yaw
from ovman_engine.plan.floorplan import Box
from ovman_engine.world.world import World

EYE = np.array([0.0, 1.5, 0.0])


def wall(yaw: float, metres: float) -> Box:
    x, z = AHEAD[YAWS_DEG.index(yaw)] * (metres + 0.5)
    return Box(np.array([x, 1.5, z]), np.array([0.5, 1.5, 0.5]), np.eye(3))


@given(st.permutations([1.0, 2.0, 3.0, 4.0]))
def test_the_open_side_is_the_one_whose_wall_is_farthest(metres: list[float]) -> None:
    walls = [wall(yaw, m) for yaw, m in zip(YAWS_DEG, metres, strict=True)]
    assert open_yaw(EYE, walls) == YAWS_DEG[int(np.argmax(metres))] == open_yaw(EYE, walls[::-1])


def test_ties_go_to_the_first_yaw_and_low_things_end_no_view() -> None:
    assert open_yaw(EYE, []) == 0.0
    assert open_yaw(EYE, [wall(0.0, 1.0)]) == 90.0
    assert open_yaw(EYE, [Box(np.array([0.0, 0.5, 1.5]), np.full(3, 0.5), np.eye(3))]) == 0.0


def test_what_was_seen_lies_before_the_agent() -> None:
    """In most scenes all visible objects are in the image; everywhere, the start repeats and is a right angle."""
    told, shown, all_of_them = 0, 0, 0
    for name in floorplan.names()[::5]:
        plan = floorplan.load(name)
        yaw = World(plan).agent.yaw_deg
        assert yaw in YAWS_DEG and World(plan).agent.yaw_deg == yaw
        if (seen := seen_yaw(plan)) is None:
            continue
        assert seen == yaw
        told += 1
        ahead = AHEAD[YAWS_DEG.index(yaw)]
        for obj in plan.objects:
            if obj.record["visible"] and obj.type != "Floor":
                all_of_them += 1
                shown += ((obj.box.corners() - plan.start)[:, [0, 2]] @ ahead).max() > 0
    assert told > 15 and shown > 0.95 * all_of_them
