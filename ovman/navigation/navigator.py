"""The navigator: from a goal on the grid to AI2-THOR's primitives, one decision per action, shared by all agents."""

from __future__ import annotations

import math

from ovman.navigation.grid import Cell, Grid, shortest_path
from ovman.settings.benchmark import Primitives

MOVE_AHEAD, ROTATE_LEFT, ROTATE_RIGHT, STOP = "MoveAhead", "RotateLeft", "RotateRight", "Stop"
PATIENCE_CELLS = 4
"""Cells by which the path that is followed may exceed the shortest one before the navigator gives it up."""


def turn_towards(yaw_deg: float, wanted_deg: float, tolerance_deg: float) -> str | None:
    """Return the shorter turn from one yaw towards another, or None within the tolerance."""
    error = (wanted_deg - yaw_deg + 180.0) % 360.0 - 180.0
    if abs(error) <= tolerance_deg + 1e-6:
        return None
    return ROTATE_RIGHT if error > 0 else ROTATE_LEFT


class Navigator:
    """A planner with A* on a grid, which may be replaced. It remembers the edges on which moves failed.

    expires: whether a blocked edge is tried again after `blocked_edge_expiry` actions (MOVING episodes) or avoided for good.
    directions: the order in which A* expands the four neighbours; it decides between paths of equal length.
    """

    def __init__(self, grid: Grid, primitives: Primitives, expires: bool, directions: tuple[Cell, ...] | None = None) -> None:
        self._grid, self._primitives, self._expires, self._directions = grid, primitives, expires, directions
        self._blocked: dict[frozenset[Cell], int] = {}
        self._actions = 0
        self._trying: frozenset[Cell] | None = None
        self._path: tuple[Cell, ...] | None = None

    def replace(self, grid: Grid) -> None:
        """Replace the grid by another one of the same lattice, because the world has changed."""
        self._grid = grid

    def decide(self, x: float, z: float, yaw_deg: float, moved: bool, goal: Cell, face: tuple[float, float]) -> str | None:
        """Return the next action of an agent at (x, z), metres, with `yaw_deg`; None if no path is left.

        moved: whether the last move succeeded. The agent goes to `goal` and, within `stop_within_m` of its centre, turns to the
        floor-plane point `face` and stops. If expiring edges block every path, it turns on the spot until one expires.
        """
        self._actions += 1
        if self._trying is not None and not moved:
            self._blocked[self._trying] = self._actions
        self._trying = None
        goal_x, goal_z = self._grid.centre(goal)
        if math.hypot(goal_x - x, goal_z - z) <= self._primitives.stop_within_m:
            return self._face(x, z, yaw_deg, face) or STOP
        here = self._grid.nearest(x, z)
        if goal == here:
            return self._face(x, z, yaw_deg, face) or STOP
        path = self._path = self._plan(here, goal)
        if path is None:
            return ROTATE_LEFT if self._expires and self._blocked else None
        turn = self._face(x, z, yaw_deg, self._grid.centre(path[1]))
        if turn is None:
            self._trying = frozenset((here, path[1]))
        return turn or MOVE_AHEAD

    def _plan(self, here: Cell, goal: Cell) -> tuple[Cell, ...] | None:
        """Return the path from here to the goal: the followed path, extended to the new goal, if that is short enough.

        A moving goal makes the shortest path flip from one side of the furniture to the other. An agent that follows every flip
        turns on the spot while the goal moves on.
        """
        avoided = self._avoided()
        shortest = shortest_path(self._grid, here, goal, avoided, self._directions)
        followed = self._rest(here, avoided)
        if shortest is None or followed is None:
            return shortest
        if goal in followed:
            kept: tuple[Cell, ...] = followed[: followed.index(goal) + 1]
        else:
            onwards = shortest_path(self._grid, followed[-1], goal, avoided, self._directions)
            kept = followed + onwards[1:] if onwards is not None else ()
        return kept if 1 < len(kept) <= len(shortest) + PATIENCE_CELLS else shortest

    def _rest(self, here: Cell, avoided: frozenset[frozenset[Cell]]) -> tuple[Cell, ...] | None:
        """Return the rest of the followed path, or None if the agent has left the path or must avoid one of its edges."""
        if self._path is None or here not in self._path:
            return None
        rest = self._path[self._path.index(here) :]
        edges = zip(rest, rest[1:], strict=False)
        blocked = any(cell not in self._grid.cells for cell in rest) or any(frozenset(edge) in avoided for edge in edges)
        return None if blocked else rest

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
