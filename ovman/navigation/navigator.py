"""The navigator: turns a goal on the grid into AI2-THOR's primitives, one decision an action, the same for every agent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ovman.navigation.grid import Cell, Grid
from ovman.navigation.plan import shortest_path

MOVE_AHEAD, ROTATE_LEFT, ROTATE_RIGHT, STOP = "MoveAhead", "RotateLeft", "RotateRight", "Stop"


@dataclass(frozen=True)
class Primitives:
    """Table "params": metres, degrees and numbers of actions."""

    step_m: float
    turn_deg: float
    heading_tolerance_deg: float
    stop_within_m: float
    blocked_edge_expiry: int

    @staticmethod
    def of(constants: Any) -> Primitives:
        """The primitives of config.yaml; `constants` must own primitives.*."""
        p = constants.primitives
        return Primitives(p.step_m, p.turn_deg, p.heading_tolerance_deg, p.stop_within_m, p.blocked_edge_expiry)


def turn_towards(yaw_deg: float, wanted_deg: float, tolerance_deg: float) -> str | None:
    """The shorter turn from one yaw towards another; None within the tolerance."""
    error = (wanted_deg - yaw_deg + 180.0) % 360.0 - 180.0
    if abs(error) <= tolerance_deg + 1e-6:
        return None
    return ROTATE_RIGHT if error > 0 else ROTATE_LEFT


class Navigator:
    """Plans with A* on a fixed grid and remembers the edges whose moves failed.

    `expires`: whether a blocked edge is tried again after `blocked_edge_expiry` actions (MOVING episodes) or avoided for good.
    `directions`: the order in which A* expands the four neighbours, which decides between paths of equal length.
    """

    def __init__(self, grid: Grid, primitives: Primitives, expires: bool, directions: tuple[Cell, ...] | None = None) -> None:
        self._grid, self._primitives, self._expires, self._directions = grid, primitives, expires, directions
        self._blocked: dict[frozenset[Cell], int] = {}
        self._actions = 0
        self._trying: frozenset[Cell] | None = None

    def decide(self, x: float, z: float, yaw_deg: float, moved: bool, goal: Cell, face: tuple[float, float]) -> str | None:
        """The next action of an agent at (x, z) with `yaw_deg`, whose last move succeeded if `moved`; None if no way is left.

        It goes to `goal` and, within `stop_within_m` of its centre, turns to the floor-plane point `face` and stops. Where the
        only ways are blocked by edges that expire, it turns on the spot until one does.
        """
        self._actions += 1
        if self._trying is not None and not moved:
            self._blocked[self._trying] = self._actions
        self._trying = None
        goal_x, goal_z = self._grid.centre(goal)
        if math.hypot(goal_x - x, goal_z - z) <= self._primitives.stop_within_m:
            return self._face(x, z, yaw_deg, face) or STOP
        here = self._grid.nearest(x, z)
        path = shortest_path(self._grid, here, goal, self._avoided(), self._directions)
        if path is None:
            return ROTATE_LEFT if self._expires and self._blocked else None
        turn = self._face(x, z, yaw_deg, self._grid.centre(path[1]))
        if turn is None:
            self._trying = frozenset((here, path[1]))
        return turn or MOVE_AHEAD

    def _avoided(self) -> frozenset[frozenset[Cell]]:
        if self._expires:
            alive = self._actions - self._primitives.blocked_edge_expiry
            self._blocked = {edge: since for edge, since in self._blocked.items() if since > alive}
        return frozenset(self._blocked)

    def _face(self, x: float, z: float, yaw_deg: float, point: tuple[float, float]) -> str | None:
        if math.hypot(point[0] - x, point[1] - z) < 1e-3:
            return None
        wanted = math.degrees(math.atan2(point[0] - x, point[1] - z))
        return turn_towards(yaw_deg, wanted, self._primitives.heading_tolerance_deg)
