"""Compare the engine's free positions with those that AI2-THOR recorded: 4,818 of version 5.0, and the grids of version 2.1.

    python bench/unity/positions.py

Rules of the engine were chosen on two thirds of the scenes ("chosen on"); the other third is held out. Agents of 5.0 stand up to
one cell of the grid nearer to walls than those of 2.1, so two overlaps (IoU) with the grids of 2.1 are given: of the engine's
reachable positions, and of those that remain if the agent keeps WALLS_2_1_M more from walls. The overlap with the grids of 5.0,
which are not recorded, is an estimate: positions were drawn uniformly, so the size of a grid follows from how often its inner
positions were drawn.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman_engine.bodies.passage import Obstacles, reachable
from ovman_engine.engine import Engine
from ovman_engine.world.world import World

CELL_M = 0.25
WALLS_2_1_M = 0.2
"""How much more AI2-THOR 2.1's agent kept from walls: of 320 sides of rooms, 5.0's positions end one cell farther out in 189."""
FEWEST = 5
"""The size of a grid is estimated if at least this many draws fell on its inner positions."""
AROUND = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]

Cell = tuple[int, int]


@dataclass(frozen=True)
class Agreement:
    """Of one scene."""

    positions: int
    accepted: int
    """Recorded positions that TeleportFull accepts"""
    reached: int
    """Recorded positions that moves reach from the start"""
    iou: float
    """With the grid of 2.1"""
    iou_clear: float
    """The same, farther from walls"""
    estimate: tuple[float, float] | None
    """Estimated common and all positions of the engine's grid and that of 5.0"""


def held_out(scenes: list[str]) -> list[str]:
    """Return every third of the sorted names."""
    return sorted(scenes)[2::3]


def cells(points: np.ndarray) -> list[Cell]:
    """Return the cells of points (N, 2)."""
    return [(int(i), int(j)) for i, j in np.round(points / CELL_M)]


def _accepted(engine: Engine, points: np.ndarray) -> int:
    count = 0
    for x, y, z in points.tolist():
        engine.answer(
            json.dumps(
                {"action": "TeleportFull", "x": x, "y": y, "z": z, "rotation": {"y": 0}, "horizon": 0, "standing": True}
            ).encode()
        )
        at = engine.session.world.agent.position
        count += bool(abs(at[0] - x) < 1e-4 and abs(at[2] - z) < 1e-4)
    return count


def _farther_from_walls(world: World) -> set[Cell]:
    obstacles, names = world.obstacles()
    wall = np.array([name.startswith("wall|") for name in names])
    reach = obstacles.reach + WALLS_2_1_M * (wall & (obstacles.reach >= obstacles.radius - 1e-9))
    x_0, z_0, x_1, z_1 = world.room.rectangle
    away = Obstacles(obstacles.boxes, reach, obstacles.radius, obstacles.low, obstacles.high)
    here = world.plan.start[[0, 2]]
    return set(cells(reachable(away, here, np.array([x_0, z_0]), np.array([x_1, z_1]), CELL_M, np.eye(2))))


def _estimate(drawn: list[Cell], grid: set[Cell], mine: set[Cell]) -> tuple[float, float] | None:
    inner = {(i, j) for i, j in grid if all((i + a, j + b) in grid for a, b in AROUND)}
    often = sum(cell in inner for cell in drawn)
    if often < FEWEST:
        return None
    each = often / len(inner)
    common = min(sum(cell in mine for cell in drawn) / each, len(mine))
    return common, len(mine) + sum(cell not in mine for cell in drawn) / each


def compare(scene: str, agent: np.ndarray, grid: np.ndarray) -> Agreement:
    """Compare a scene with its recorded draws of positions (N, 3) and its grid (M, 2)."""
    engine = Engine(draws=False)
    for request in ({"action": "Reset", "sceneName": scene}, {"action": "Initialize", "snapToGrid": False}):
        engine.answer(json.dumps(request).encode())
    world = engine.session.world
    mine = set(cells(np.array(world.reachable(CELL_M))[:, [0, 2]]))
    drawn, theirs, away = cells(agent[:, [0, 2]]), set(cells(grid)), _farther_from_walls(world)
    _, first = np.unique(drawn, axis=0, return_index=True)
    return Agreement(
        len(first),
        _accepted(engine, agent[first]),
        len(set(drawn) & mine),
        len(mine & theirs) / len(mine | theirs),
        len(away & theirs) / len(away | theirs),
        _estimate(drawn, theirs, mine),
    )


def main() -> None:
    """Print the figures of both parts of the scenes."""
    recorded = np.load(Path(__file__).with_name("recorded.npz"))
    scenes = sorted(set(recorded["agent_scene"].tolist()))
    found = {
        scene: compare(
            scene,
            recorded["agent"][recorded["agent_scene"] == scene].astype(float),
            recorded["grid"][recorded["grid_scene"] == scene].astype(float),
        )
        for scene in scenes
    }
    held = held_out(scenes)
    print(f"{'scenes':<12}{'positions':>10}{'accepted':>10}{'reached':>10}{'IoU 2.1':>10}{'farther':>10}{'IoU 5.0':>10}")
    for name, part in (("chosen on", sorted(set(scenes) - set(held))), ("held out", held), ("all", scenes)):
        rows = [found[scene] for scene in part]
        total = sum(r.positions for r in rows)
        guess = np.sum([r.estimate for r in rows if r.estimate], axis=0)
        print(
            f"{name:<12}{total:>10}{sum(r.accepted for r in rows) / total:>10.2%}{sum(r.reached for r in rows) / total:>10.2%}"
            f"{np.mean([r.iou for r in rows]):>10.4f}{np.mean([r.iou_clear for r in rows]):>10.4f}{guess[0] / guess[1]:>10.3f}"
        )


if __name__ == "__main__":
    main()
