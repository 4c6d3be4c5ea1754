"""The layout prior, a control: where a thing of the category usually stands, from the noun and a grid, without pictures.

layout.json has, per category, how far things of homes with train assets stand from walls, from the middle of their room, from
openings and from free floor; `python -m training.layout` counts them. The answer has the most probability around it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import Answer, PredictionContext, Query

COUNTS = Path(__file__).with_suffix(".json")
STEP_M = 0.25
EDGES: Mapping[str, tuple[float, ...]] = {
    "wall_m": (0.1, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0),
    "middle": (0.2, 0.4, 0.6, 0.7, 0.8, 0.9),
    "opening_m": (0.75, 1.25, 2.0, 3.0),
    "free_m": (0.01, 0.3, 0.45, 0.6, 0.8),
}
"""Ends of the bins of each distance. middle: the distance from the middle of the room as a share of half its diagonal."""
BODY_M = 0.2
"""Walls are about so far from the outermost points of the grid."""
DOOR_CELLS, ROOM_CELLS = 4, 8
"""Rooms meet in a line of the grid with so few points, and are at least so long."""
AROUND_M = 0.75
"""Things stand at most so far from the grid."""
RADIUS_M = 1.0
"""Radius in which probabilities are added up: the benchmark's success radius."""
PSEUDO = 2.0
"""Pseudocounts of a bin, spread as the background is."""


def predict(query: Query, context: PredictionContext) -> tuple[Answer, None]:
    """Answer as the static arm layout_prior. Of the query it reads the category alone."""
    grid = context.grid
    places = lay_lattice(grid)
    log = score_places(query.category, describe_places(grid, places))
    chance = np.exp(log - log.max())
    near = np.linalg.norm(places[:, None] - places[None], axis=2) <= RADIUS_M
    best = places[int((near @ chance).argmax())]
    return Answer(float(best[0]), float(best[1])), None


def score_places(category: str, binned: np.ndarray) -> np.ndarray:
    """Return the log probability (N,), up to a constant, that a thing of a category stands at places with these bins (N, 4)."""
    counts = read_counts()
    log = np.zeros(len(binned))
    for column, name in enumerate(EDGES):
        background = np.array(counts["background"][name], float) + 1.0
        background /= background.sum()
        own = np.array(counts["categories"].get(category, {}).get(name, [0] * len(background)), float)
        own += PSEUDO * len(background) * background
        log += np.log(own / own.sum() / background)[binned[:, column]]
    return log


@cache
def read_counts() -> dict[str, Any]:
    """Return the counts of layout.json: of lattice points ("background") and of things by category, per distance and bin."""
    counts: dict[str, Any] = json.loads(COUNTS.read_text(encoding="utf-8"))
    return counts


def lay_lattice(grid: np.ndarray) -> np.ndarray:
    """Return the points (N, 2) of a lattice at which things could stand: up to AROUND_M from the grid (K, 2), metres."""
    low, high = grid.min(axis=0) - AROUND_M, grid.max(axis=0) + AROUND_M
    x, z = (np.arange(start, stop + STEP_M / 2, STEP_M) for start, stop in zip(low, high, strict=True))
    points = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[_distances(points, grid) <= AROUND_M]


def describe_places(grid: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the bin of each distance of EDGES for places (N, 2) of a home with this grid (K, 2): (N, 4) int."""
    rooms, openings = split_rooms(grid)
    low, high = (np.array([room[end] for room in rooms]) for end in (0, 1))
    inside = np.minimum(places[:, None] - low[None], high[None] - places[:, None]).min(axis=2)
    room = inside.argmax(axis=1)
    half = (high - low) / 2
    middle = np.linalg.norm(places - (low + half)[room], axis=1) / np.linalg.norm(half, axis=1)[room]
    measured = (inside.max(axis=1), middle, _distances(places, openings), _distances(places, grid))
    return np.stack([np.digitize(value, EDGES[name]) for name, value in zip(EDGES, measured, strict=True)], axis=1)


def split_rooms(grid: np.ndarray) -> tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray]:
    """Return the boxes (low, high) of the rooms of a grid (K, 2), metres, and the points (L, 2) of the openings between them."""
    cells = np.round(grid / STEP_M).astype(np.int64)
    parts = list(_split(cells))
    rooms = [(part.min(axis=0) * STEP_M - BODY_M, part.max(axis=0) * STEP_M + BODY_M) for part, _ in parts]
    return rooms, np.concatenate([opening for _, opening in parts]) * STEP_M


def _split(cells: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the cells of each room, with the cells of the line at which it was cut off."""
    best: tuple[int, int, int] | None = None
    for axis in (0, 1):
        counts = np.bincount(cells[:, axis] - (start := int(cells[:, axis].min())))
        for k in range(ROOM_CELLS, len(counts) - ROOM_CELLS):
            if 0 < counts[k] <= DOOR_CELLS and (best is None or counts[k] < best[0]):
                best = int(counts[k]), axis, start + k
    if best is None:
        yield cells, np.zeros((0, 2), np.int64)
        return
    _, axis, at = best
    along = cells[:, axis]
    yield cells[along < at], cells[along == at]
    yield from _split(cells[along > at])


def _distances(places: np.ndarray, others: Sequence[Sequence[float]] | np.ndarray) -> np.ndarray:
    """Return the distance (N,) of each place to the nearest of others, infinite for none."""
    others = np.asarray(others, float).reshape(-1, 2)
    nearest: np.ndarray = np.linalg.norm(places[:, None] - others[None], axis=2).min(axis=1, initial=np.inf)
    return nearest
