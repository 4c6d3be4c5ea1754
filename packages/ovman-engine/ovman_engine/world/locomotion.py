"""Where the agent can move in a world. World frame as in `floorplan`."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import ArrayLike

from ovman_engine.bodies.body import Agent, Body
from ovman_engine.bodies.embodiment import Embodiment
from ovman_engine.bodies.footprint import Boxes
from ovman_engine.bodies.passage import Obstacles, first_hit, heading, reachable
from ovman_engine.bodies.static_scene import PASSABLE, StaticScene


class Locomotion:
    """Answers for the agent at its current position. `version` is the world's; obstacles are cached for the last version."""

    def __init__(self, static: StaticScene, bodies: Mapping[str, Body], agent: Agent) -> None:
        """`bodies` and `agent` are the world's own and may change between calls."""
        self._static, self._bodies, self._agent = static, bodies, agent
        self._known: tuple[int, float, Embodiment, Obstacles, list[str]] | None = None

    def blocker(self, version: int, start_xz: ArrayLike, end_xz: ArrayLike, ignore: Collection[str] = ()) -> str | None:
        """Name of the obstacle on the straight way from `start_xz` to `end_xz` (metres), None if it is free.

        A body that the agent overlaps already blocks only ways that lead deeper into it. If both points are equal, the result is
        an obstacle that the agent overlaps there.
        """
        obstacles, names = self.obstacles(version)
        if ignore:
            kept = np.array([i for i, name in enumerate(names) if name not in ignore], dtype=int)
            obstacles, names = obstacles.take(kept), [names[i] for i in kept]
        hit = first_hit(obstacles, np.array(start_xz, dtype=float), np.array(end_xz, dtype=float))
        return None if hit is None else names[hit]

    def reachable(self, version: int, step_m: float, yaw_deg: float) -> list[tuple[float, float, float]]:
        """Positions (x, y, z) that moves of `step_m` along the yaw and across it reach, the agent's own first.

        Y is the agent's.
        """
        x_0, z_0, x_1, z_1 = self._static.room.rectangle
        here = self._agent.position[[0, 2]]
        axes = np.stack([heading(yaw_deg + 90.0), heading(yaw_deg)])
        found = reachable(self.obstacles(version)[0], here, np.array([x_0, z_0]), np.array([x_1, z_1]), step_m, axes)
        y = float(self._agent.position[1])
        return [(x, y, z) for x, z in found.tolist()]

    def obstacles(self, version: int) -> tuple[Obstacles, list[str]]:
        """Possible obstacles and their names: walls, then bodies, some of them in several boxes."""
        foot, agent = self._agent.foot, self._agent.embodiment
        if self._known is None or self._known[:3] != (version, foot, agent):
            bodies = [b for b in self._bodies.values() if b.present and b.obj.type not in PASSABLE]
            known, walls = self._static.clearances(agent), self._static.room.walls
            names, reach, boxes = [w.name for w in walls], [known[w.name] for w in walls], []
            for body in bodies:
                barriers = self._static.barriers(body.obj, body.box)
                names += [body.object_id] * len(barriers)
                boxes += barriers
                away = np.full(len(barriers), agent.radius_m)
                reach.append(known[body.obj.object_id] if body.untouched else away)
            solid = self._static.walls.join(Boxes.of(boxes))
            obstacles = Obstacles(solid, np.concatenate([np.zeros(0), *reach]), agent.radius_m, *agent.axis(foot))
            self._known = version, foot, agent, obstacles, names
        return self._known[3:]
