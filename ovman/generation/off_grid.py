"""Tours off the grid: an agent that rounds its sensed poses to cells and quarters of a turn does not undo their errors. Pure."""

from __future__ import annotations

from itertools import product

import numpy as np

from ovman.navigation.grid import Grid
from ovman.records.geometry import Point
from ovman.records.record import DEGREE_DECIMALS, METRE_DECIMALS
from ovman.records.scene import Scene
from ovman.records.tour import Tour
from ovman.sim.world import AGENT_RADIUS_M

TURN_DEG = 3.0
"""Farthest that a view is turned from the equal spacing of its waypoint's views: ten times the error of good sensors."""
SHARES = (0.1, 0.5)
"""Least and greatest offset from a waypoint along each axis, as a share of a step: it stays in its cell."""


def take_off_grid(tour: Tour, scene: Scene, step_m: float, rng: np.random.Generator) -> Tour:
    """Return a tour whose waypoints lie between cells and whose views are turned by a little.

    A waypoint moves within a square of four cells that the agent can reach, so that the floor there is free. Where there is no
    such square it moves towards a neighbouring cell.
    """
    reachable = np.array(scene.reachable)
    grid = Grid.from_positions(reachable[scene.are_off_spares(reachable, AGENT_RADIUS_M)], step_m)

    def move(point: Point) -> Point:
        i, j = grid.nearest(*point)
        ways = [(di, dj) for di, dj in product((-1, 1), (-1, 1)) if {(i + di, j), (i, j + dj), (i + di, j + dj)} <= grid.cells]
        ways = ways or [(di, dj) for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)) if (i + di, j + dj) in grid.cells] or [(0, 0)]
        way = np.array(ways[int(rng.integers(len(ways)))])
        x, z = np.array(point) + step_m * way * rng.uniform(*SHARES, 2)
        return round(float(x), METRE_DECIMALS), round(float(z), METRE_DECIMALS)

    first_yaw_deg = (tour.first_yaw_deg + float(rng.uniform(0.0, 360.0 / tour.headings))) % 360.0
    turned = rng.uniform(-TURN_DEG, TURN_DEG, len(tour.waypoints) * tour.headings)
    return tour.model_copy(
        update={
            "waypoints": tuple(map(move, tour.waypoints)),
            "first_yaw_deg": round(first_yaw_deg, DEGREE_DECIMALS) % 360.0,
            "turned_deg": tuple(round(float(angle), DEGREE_DECIMALS) for angle in turned),
        }
    )
