"""The mover of a MOVING episode: an object that goes back and forth on a straight free lane while the agent acts.

It advances a fixed length for every action of the agent (views of a tour count as actions), pauses and turns back at random,
turns at the ends of its lane, and waits when the agent stands in its way. It is driven by teleporting the object as a kinematic
body, so what it passes is not pushed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ovman.models.settings import Settings


@dataclass(frozen=True)
class Lane:
    """A straight lane on the floor plane from (x_0, z_0) to (x_1, z_1), metres."""

    x_0: float
    z_0: float
    x_1: float
    z_1: float

    @property
    def length_m(self) -> float:
        return float(np.hypot(self.x_1 - self.x_0, self.z_1 - self.z_0))

    def at(self, along_m: float) -> tuple[float, float]:
        """Point `along_m` metres from the lane's beginning."""
        share = along_m / self.length_m
        return self.x_0 + share * (self.x_1 - self.x_0), self.z_0 + share * (self.z_1 - self.z_0)

    def along(self, x: float, z: float) -> float:
        """Metres from the lane's beginning of the point of the lane nearest to (x, z)."""
        dx, dz = self.x_1 - self.x_0, self.z_1 - self.z_0
        share = ((x - self.x_0) * dx + (z - self.z_0) * dz) / (dx * dx + dz * dz)
        return float(np.clip(share, 0.0, 1.0)) * self.length_m


@dataclass(frozen=True)
class Gait:
    """How a mover goes: metres per agent action and probabilities per agent action."""

    step_m: float
    pause_probability: float
    turn_probability: float

    @staticmethod
    def of(constants: Settings) -> Gait:
        """The gait of config.yaml; `constants` must own mover.*."""
        mover = constants.mover
        return Gait(mover.step_m, mover.pause_probability, mover.turn_probability)


@dataclass(frozen=True)
class Mover:
    """State of a mover: metres along its lane and direction (+1 or -1)."""

    lane: Lane
    along_m: float = 0.0
    direction: int = 1

    @property
    def position(self) -> tuple[float, float]:
        return self.lane.at(self.along_m)

    def advance(self, gait: Gait, rng: np.random.Generator, keep_clear_of: tuple[float, float], clearance_m: float) -> Mover:
        """The mover after one agent action.

        Always draws the same number of variates, so that the path under a seed depends on the agent only where it is in the way:
        a step that would come closer than `clearance_m` to the agent at `keep_clear_of` is not taken and turns the mover back.
        """
        pause, turn = rng.random(2)
        if pause < gait.pause_probability:
            return self
        direction = -self.direction if turn < gait.turn_probability else self.direction
        target = self.along_m + direction * gait.step_m
        if not 0.0 <= target <= self.lane.length_m:
            direction = -direction
            target = float(np.clip(self.along_m + direction * gait.step_m, 0.0, self.lane.length_m))
        x, z = self.lane.at(target)
        here_x, here_z = self.position
        agent_x, agent_z = keep_clear_of
        now, then = np.hypot(here_x - agent_x, here_z - agent_z), np.hypot(x - agent_x, z - agent_z)
        if then < clearance_m and then < now:
            return replace(self, direction=-direction)
        return Mover(self.lane, target, direction)
