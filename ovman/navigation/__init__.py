"""The grid of reachable cells, shortest paths on it, and the navigator that follows them with primitives."""

from ovman.navigation.grid import DIRECTIONS, Cell, Edge, Grid, farthest_points, geodesic_m, shortest_path, steps_from
from ovman.navigation.navigator import Navigator

__all__ = [
    "DIRECTIONS",
    "Cell",
    "Edge",
    "Grid",
    "Navigator",
    "farthest_points",
    "geodesic_m",
    "shortest_path",
    "steps_from",
]
