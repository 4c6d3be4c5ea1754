"""The mover of a MOVING episode: an object that goes back and forth on a straight free lane while the agent acts.

It advances a fixed length for every action of the agent (views of a tour count as actions), pauses and turns back at random,
turns at the ends of its lane, and waits when the agent stands in its way. It is driven by teleporting the object as a kinematic
body, so what it passes is not pushed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ovman.models.change import Lane
from ovman.models.geometry import Point
from ovman.models.settings.benchmark import Mover as MoverParams


@dataclass(frozen=True)
class Mover:
    """State of a mover: metres along its lane, and its direction, +1 away from the lane's beginning or -1 back."""

    lane: Lane
    along_m: float = 0.0
    direction: int = 1

    @property
    def position(self) -> Point:
        """Floor-plane position in metres."""
        return self.lane.at(self.along_m)

    def advance(self, params: MoverParams, rng: np.random.Generator, keep_clear_of: Point, clearance_m: float) -> Mover:
        """The mover after one agent action.

        params: must own step_m, pause_probability and turn_probability. Always draws the same number of variates, so that the
        path under a seed depends on the agent only where it is in the way: a step that would come closer than `clearance_m` to
        the agent at `keep_clear_of` is not taken and turns the mover back.
        """
        pause, turn = rng.random(2)
        if pause < params.pause_probability:
            return self
        direction = -self.direction if turn < params.turn_probability else self.direction
        target = self.along_m + direction * params.step_m
        if not 0.0 <= target <= self.lane.length_m:
            direction = -direction
            target = float(np.clip(self.along_m + direction * params.step_m, 0.0, self.lane.length_m))
        x, z = self.lane.at(target)
        here_x, here_z = self.position
        agent_x, agent_z = keep_clear_of
        now, then = np.hypot(here_x - agent_x, here_z - agent_z), np.hypot(x - agent_x, z - agent_z)
        if then < clearance_m and then < now:
            return replace(self, direction=-direction)
        return Mover(self.lane, target, direction)
