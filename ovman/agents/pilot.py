"""From a goal point to primitives: the navigation of all agents of this package."""

from __future__ import annotations

import numpy as np

from ovman.agents.interface.observation import Action, Observation
from ovman.navigation import Cell, Grid, Navigator
from ovman.records.relation import Relation
from ovman.settings.benchmark import Primitives

QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Pilot:
    """Drives to goal points on the grid of reachable positions. rng: chooses among paths of equal length."""

    def __init__(self, primitives: Primitives, rng: np.random.Generator) -> None:
        self._primitives = primitives
        self._directions = tuple(QUARTERS[k] for k in rng.permutation(len(QUARTERS)))
        self._navigator: Navigator | None = None

    def set_out(self, reachable: np.ndarray, relation: Relation) -> None:
        """Begin an episode on the positions `reachable` (K, 2), metres. Blocked edges are retried in MOVING episodes only."""
        self._take(reachable)
        self._navigator = Navigator(self._grid, self._primitives, relation is Relation.MOVING, self._directions)

    def _take(self, reachable: np.ndarray) -> None:
        self._grid = Grid.from_positions([(float(x), float(z)) for x, z in reachable], self._primitives.step_m)
        self._component: frozenset[Cell] | None = None

    def act(self, observation: Observation, goal: tuple[float, float]) -> Action:
        """One primitive towards the navigable cell nearest to `goal`; STOP there, facing it; ABSTAIN if it is unreachable."""
        assert self._navigator is not None, "set_out comes first"
        pose = observation.pose
        if observation.reachable is not None:
            self._take(observation.reachable)
            self._navigator.replace(self._grid)
        if self._component is None:
            self._component = frozenset(self._grid.component(self._grid.nearest(pose.x, pose.z)))
        cell = self._grid.nearest(*goal, within=self._component)
        action = self._navigator.decide(pose.x, pose.z, pose.yaw_deg, observation.last_action_succeeded, cell, goal)
        return Action.ABSTAIN if action is None else Action(action)
