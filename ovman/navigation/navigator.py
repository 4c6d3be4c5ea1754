"""The navigator: from a goal on the grid to AI2-THOR's primitives, one decision per action, shared by all agents."""

from __future__ import annotations

import math
from collections import Counter

from ovman.navigation.grid import Cell, Grid, shortest_path, steps_from
from ovman.settings.benchmark import Primitives

MOVE_AHEAD, ROTATE_LEFT, ROTATE_RIGHT, STOP = "MoveAhead", "RotateLeft", "RotateRight", "Stop"
PATIENCE_CELLS = 4
"""Cells by which the path that is followed may exceed the shortest one before the navigator gives it up."""

ARRIVED_M = 0.2
"""On an outdated grid the agent goes this close to its cell, less than a step, unless something bars the way."""
BESIDE_M = 1.0
"""An obstacle at most this far from the goal may be the thing that the agent looks for; one farther away is not."""
ATTEMPTS = 4
"""Failed moves at most `BESIDE_M` from the goal until the agent stops there."""


def turn_towards(yaw_deg: float, wanted_deg: float, tolerance_deg: float) -> str | None:
    """Return the shorter turn from one yaw towards another, or None within the tolerance."""
    error = (wanted_deg - yaw_deg + 180.0) % 360.0 - 180.0
    if abs(error) <= tolerance_deg + 1e-6:
        return None
    return ROTATE_RIGHT if error > 0 else ROTATE_LEFT


class Navigator:
    """A planner with A* on a grid, which may be replaced. It remembers the edges on which moves failed.

    expires: whether a blocked edge is tried again after `blocked_edge_expiry` actions (MOVING episodes) or avoided for good.
    directions: the order in which A* expands the four neighbours; it decides between paths of equal length. outdated: whether
    things may stand on the grid by now. A failed move then blocks the edges on both sides of its own, too, since things are wider
    than a cell. If blocked edges cut off the cell of the goal, the agent goes to the nearest cell that they do not cut off; if
    that is far from the goal, it tries them again, each time after twice as many actions. It stops within `ARRIVED_M` of the
    cell, within `stop_within_m` after a move failed there, and within `BESIDE_M` after several did (for MOVING after one).
    """

    def __init__(
        self,
        grid: Grid,
        primitives: Primitives,
        expires: bool,
        directions: tuple[Cell, ...] | None = None,
        outdated: bool = False,
    ) -> None:
        self._grid, self._primitives, self._expires, self._directions = grid, primitives, expires, directions
        self._outdated, self._attempts = outdated, 1 if expires else ATTEMPTS
        self._within_m = ARRIVED_M if outdated and not expires else primitives.stop_within_m
        self._blocked: dict[frozenset[Cell], int] = {}
        self._failures: Counter[frozenset[Cell]] = Counter()
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
        here, goal_m = self._grid.nearest(x, z), math.dist((x, z), self._grid.centre(goal))
        if self._trying is not None and not moved:
            self._block(self._trying)
            if self._outdated:
                self._relax(goal_m)
        self._trying = None
        if goal == here or goal_m <= self._within_m:
            return self._face(x, z, yaw_deg, face) or STOP
        if self._outdated:
            goal = self._find_open(here, goal)
            if goal == here and goal_m > BESIDE_M:
                self._expire()
                return ROTATE_LEFT
            if goal == here:
                return self._face(x, z, yaw_deg, face) or STOP
        path = self._path = self._plan(here, goal)
        if path is None:
            return ROTATE_LEFT if self._expires and self._blocked else None
        turn = self._face(x, z, yaw_deg, self._grid.centre(path[1]))
        if turn is None:
            self._trying = frozenset((here, path[1]))
        return turn or MOVE_AHEAD

    def _block(self, edge: frozenset[Cell]) -> None:
        """Avoid an edge on which a move failed."""
        edges = [edge]
        if self._outdated:
            (i, j), (to_i, to_j) = edge
            for di, dj in ((to_j - j, to_i - i), (j - to_j, i - to_i)):
                edges.append(frozenset(((i + di, j + dj), (to_i + di, to_j + dj))))
        for one in edges:
            self._blocked[one] = self._actions
            self._failures[one] += 1

    def _relax(self, goal_m: float) -> None:
        """Let the agent stop farther from its goal, since a move failed `goal_m` metres from it."""
        if goal_m <= self._primitives.stop_within_m:
            self._within_m = max(self._within_m, self._primitives.stop_within_m)
        if goal_m <= BESIDE_M:
            self._attempts -= 1
            if self._attempts <= 0:
                self._within_m = BESIDE_M

    def _find_open(self, here: Cell, goal: Cell) -> Cell:
        """Return the cell nearest to the goal that no blocked edges cut off from here."""
        avoided = self._avoided()
        return self._grid.nearest(*self._grid.centre(goal), within=steps_from(self._grid, here, avoided)) if avoided else goal

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
            self._expire()
        return frozenset(self._blocked)

    def _expire(self) -> None:
        """Forget the blocked edges that were avoided for long enough."""
        expiry = self._primitives.blocked_edge_expiry
        again = {edge: expiry * 2 ** (self._failures[edge] - 1) if self._outdated else expiry for edge in self._blocked}
        self._blocked = {edge: since for edge, since in self._blocked.items() if self._actions - since < again[edge]}

    def _face(self, x: float, z: float, yaw_deg: float, point: tuple[float, float]) -> str | None:
        if math.hypot(point[0] - x, point[1] - z) < 1e-3:
            return None
        wanted = math.degrees(math.atan2(point[0] - x, point[1] - z))
        return turn_towards(yaw_deg, wanted, self._primitives.heading_tolerance_deg)
