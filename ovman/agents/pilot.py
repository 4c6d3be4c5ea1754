"""From a goal point to primitives: the navigation of all agents of this package."""

from __future__ import annotations

import numpy as np

from ovman.agents.interface import Abstention, Action, AgentContext, Answer, Instruction, Observation, Query, Relation, Visit
from ovman.agents.words import understand
from ovman.navigation.grid import Cell, Grid
from ovman.navigation.navigator import Navigator
from ovman.records.prediction import as_recorded
from ovman.settings.benchmark import Primitives

QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Pilot:
    """Drives to goal points on the grid of reachable positions.

    rng: chooses among paths of equal length. outdated: whether the grid is that of visit 1, on which things may stand by now.
    """

    def __init__(self, primitives: Primitives, rng: np.random.Generator, outdated: bool = False) -> None:
        self._primitives, self._outdated = primitives, outdated
        self._directions = tuple(QUARTERS[k] for k in rng.permutation(len(QUARTERS)))
        self._navigator: Navigator | None = None

    def set_out(self, reachable: np.ndarray, relation: Relation | None = None) -> None:
        """Begin an episode on the positions `reachable` (K, 2), metres. For MOVING, blocked edges are tried again."""
        self._take(reachable)
        self._navigator = Navigator(self._grid, self._primitives, relation is Relation.MOVING, self._directions, self._outdated)

    def _take(self, reachable: np.ndarray) -> None:
        self._grid = Grid.from_positions([(float(x), float(z)) for x, z in reachable], self._primitives.step_m)
        self._component: frozenset[Cell] | None = None
        self._nearest: tuple[tuple[float, float], Cell] | None = None

    def act(self, observation: Observation, goal: tuple[float, float]) -> Action:
        """Return the next primitive towards the navigable cell nearest to `goal`.

        It is STOP at that cell, facing the goal, and ABSTAIN if the cell is unreachable.
        """
        assert self._navigator is not None, "set_out comes first"
        pose, goal = observation.pose, (float(goal[0]), float(goal[1]))  # agents of users give arrays, too
        if observation.reachable is not None:
            self._take(observation.reachable)
            self._navigator.replace(self._grid)
        if self._component is None:
            self._component = frozenset(self._grid.component(self._grid.nearest(pose.x, pose.z)))
        if self._nearest is None or self._nearest[0] != goal:  # most agents keep their goal, and the search takes a millisecond
            self._nearest = goal, self._grid.nearest(*goal, within=self._component)
        succeeded, cell = observation.last_action_succeeded, self._nearest[1]
        action = self._navigator.decide(pose.x, pose.z, pose.yaw_deg, succeeded, cell, goal)
        return Action.ABSTAIN if action is None else Action(action)


class GoalAgent:
    """An agent that decides once, when it is asked, and drives to its answer without images. A subclass decides."""

    looks = False

    def __init__(self, context: AgentContext) -> None:
        self.context = context

    def familiarise(self, visit: Visit) -> None:
        """Keep the first tour."""
        self.first = visit

    def revisit(self, visit: Visit) -> None:
        """Keep the second tour."""
        self.second = visit

    def ask(self, query: Instruction) -> None:
        """Decide and set out; abstain if the sentence of an instruction is not understood."""
        understood = understand(query)
        if isinstance(understood, Abstention):
            self.goal: Answer | Abstention = understood
            return
        self.goal = self.decide(understood)
        self.context.pilot.set_out(self.second.reachable, understood.relation)

    def decide(self, query: Query) -> Answer | Abstention:
        """Answer a query about the two tours."""
        raise NotImplementedError

    def act(self, observation: Observation) -> Action:
        """Return the next primitive towards the answer, ABSTAIN without one."""
        if isinstance(self.goal, Abstention):
            return Action.ABSTAIN
        return self.context.pilot.act(observation, (self.goal.x, self.goal.z))


class Executor(GoalAgent):
    """Drives to the answer of the static arm that its own arm `executes`. A subclass predicts it if it is not recorded."""

    def decide(self, query: Query) -> Answer | Abstention:
        """Return the recorded prediction, or the predicted one as it would be recorded."""
        answered = self.context.answered
        return as_recorded(self.predict(query)) if answered is None else answered

    def predict(self, query: Query) -> Answer | Abstention:
        """Answer as the static arm."""
        raise NotImplementedError
