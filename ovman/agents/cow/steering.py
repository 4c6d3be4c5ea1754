"""From a waypoint to actions: the low-level planner."""

from __future__ import annotations

import heapq
import math

from ovman.agents.cow.odometry import Pose
from ovman.agents.cow.settings import Cow
from ovman.agents.cow.voxel_map import Cell, VoxelMap, VoxelState
from ovman.agents.interface import Action
from ovman.settings.benchmark import Primitives


def turns(by: int) -> tuple[Action, ...]:
    """`by` turns to the left, or to the right if it is negative."""
    return (Action.ROTATE_LEFT if by > 0 else Action.ROTATE_RIGHT,) * abs(by)


def headings(count: int) -> tuple[int, ...]:
    """Turns to the left for each of `count` headings: 0, 1, -1, ... up to the half turn, which is to the left."""
    return tuple(sorted(range(1 - (count + 1) // 2, count // 2 + 1), key=lambda k: (abs(k), k < 0)))


def steered(
    known: VoxelMap, pose: Pose, goal: Cell, constants: Cow, primitives: Primitives, forbidden: Action | None = None
) -> tuple[Action, ...] | None:
    """Actions, at least one, that lead to within `waypoint_voxels` of a goal; None if the search fails.

    Best-first search by the distance to the goal over macro-actions, each a turn to one of the headings and a step. At most
    `expansions` nodes are expanded, every cell is entered once, and no occupied one. `forbidden` must not begin the first
    macro-action, because it has just failed.
    """
    scale = 1.0 / constants.voxel_m

    def away(at: Pose) -> float:
        return math.hypot(at.x * scale - goal[0], at.z * scale - goal[1])

    def rounded(at: Pose) -> Cell:
        return round(at.x * scale), round(at.z * scale)

    waiting: list[tuple[float, int, Pose, tuple[Action, ...]]] = [(away(pose), 0, pose, ())]
    entered, made = {rounded(pose)}, 0
    ways = headings(round(360.0 / primitives.turn_deg))
    for _ in range(constants.expansions):
        if not waiting:
            return None
        distance, _, at, actions = heapq.heappop(waiting)
        if actions and distance <= constants.waypoint_voxels:
            return actions
        for by in ways:
            macro = (*turns(by), Action.MOVE_AHEAD)
            if not actions and macro[0] is forbidden:
                continue
            after = at
            for action in macro:
                after = after.after(action, primitives.step_m, primitives.turn_deg)
            cell = rounded(after)
            if cell in entered or known.at(cell) is VoxelState.OCCUPIED:
                continue
            entered.add(cell)
            made += 1
            heapq.heappush(waiting, (away(after), made, after, (*actions, *macro)))
    return None


def facing(pose: Pose, target: Cell, constants: Cow, primitives: Primitives) -> tuple[Action, ...]:
    """The turns to the heading that is nearest to the direction of a cell."""
    dx, dz = target[0] * constants.voxel_m - pose.x, target[1] * constants.voxel_m - pose.z
    bearing = math.degrees(math.atan2(dx, dz))

    def off(by: int) -> float:
        return abs((bearing - (pose.yaw_deg - by * primitives.turn_deg) + 180.0) % 360.0 - 180.0)

    return turns(min(headings(round(360.0 / primitives.turn_deg)), key=lambda by: (round(off(by), 6), abs(by))))
