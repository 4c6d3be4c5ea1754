"""Pursuit: following what moves by depth alone, while driving to it."""

from __future__ import annotations

import math

import numpy as np

from ovman.agents.interface import Action, Observation, Visit
from ovman.agents.joint.segments import left_over
from ovman.agents.joint.sight import Frame, frame, frames, grid_votes
from ovman.settings import Settings


class Pursuit:
    """Where something that moves is thought to be: `place`, (x, z) in metres.

    visit: the tour in which it was seen last; place: where. settings: sections joint and primitives.
    """

    def __init__(self, visit: Visit, place: tuple[float, float], settings: Settings) -> None:
        self.place = place
        self._joint, self._turns = settings.joint, round(360 / settings.primitives.turn_deg)
        self._known: tuple[Frame, ...] = frames(visit, self._joint)
        self._seen = False
        self._turned = 0

    def look(self, observation: Observation) -> None:
        """Take the nearest thing that stands where the tour saw through, if it is near enough to where the mover is thought."""
        found = sorted(self._moved(observation), key=lambda place: math.dist(place, self.place))
        self._seen = bool(found) and math.dist(found[0], self.place) <= self._joint.pursuit_m
        if self._seen:
            self.place, self._turned = found[0], 0

    @property
    def lost(self) -> bool:
        """Whether it is out of sight, and was not looked for all around since it was seen last."""
        return not self._seen and self._turned < self._turns

    @property
    def searching(self) -> bool:
        """Whether a look around has begun and found nothing yet."""
        return self.lost and self._turned > 0

    def turn(self) -> Action:
        """The next turn of a look around."""
        self._turned += 1
        return Action.ROTATE_LEFT

    def _moved(self, observation: Observation) -> list[tuple[float, float]]:
        """The places (x, z) of what a frame shows where the tour saw through."""
        one = frame(observation, self._joint)
        grid = grid_votes([one], self._known, self._joint)[0]
        places = [np.median(one.points[part], axis=0) for part in left_over(grid, np.zeros(one.known.shape, bool), self._joint)]
        return [(float(place[0]), float(place[2])) for place in places]
