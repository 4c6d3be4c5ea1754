"""A mover of a MOVING episode: an object that walks at random over free floor while the agent acts.

It starts where it stands. For every action of the agent (views of a tour count as actions) it goes one step of its lattice along
its heading, pauses or turns at random, turns where its way is barred, and stays where every way is. It is driven by teleporting
the object as a kinematic body, so what it passes is not pushed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ovman.records.change import Cell, HeadingDeg, MoverStart, Roam
from ovman.records.geometry import Point
from ovman.settings.benchmark import Mover as MoverParams

WAYS: Mapping[HeadingDeg, Cell] = {0: (0, 1), 90: (1, 0), 180: (0, -1), 270: (-1, 0)}
"""The steps of a lattice, (along x, along z), by their headings."""


def streams(rng: np.random.Generator, number: int) -> list[np.random.Generator]:
    """The streams of so many movers of one tour or run, the first of them `rng` itself.

    The others are spawned from it, so the walk of one does not depend on how many there are.
    """
    return [rng, *rng.spawn(number - 1)] if number else []


@dataclass(frozen=True)
class Mover:
    """State of a mover: the point of its lattice where it is, and which way it goes on."""

    roam: Roam
    cell: Cell = (0, 0)
    heading_deg: HeadingDeg = 0

    @staticmethod
    def setting_off(roam: Roam, rng: np.random.Generator) -> Mover:
        """The mover where the instance stands, with a heading that is drawn."""
        return Mover(roam, heading_deg=list(WAYS)[int(rng.integers(len(WAYS)))])

    def resumed(self, start: MoverStart) -> Mover:
        """The mover in the state in which a recorded visit left it. ValueError for a place off its floor."""
        cell = self.roam.cell(start.position)
        if cell not in self.roam.cells:
            raise ValueError(f"{start.instance} is at {start.position}, off the floor that it roams")
        return Mover(self.roam, cell, start.heading_deg)

    @property
    def position(self) -> Point:
        """Floor-plane position in metres."""
        return self.roam.at(self.cell)

    def neighbours(self) -> list[Cell]:
        """The free points of the lattice one step away."""
        return [cell for heading in WAYS if (cell := self._next(heading)) in self.roam.cells]

    def advance(
        self, params: MoverParams, rng: np.random.Generator, keep_clear_of: Point | None = None, clearance_m: float = 0.0
    ) -> Mover:
        """The mover after one agent action.

        params: must own pause_probability and turn_probability. Always draws the same number of variates, so that the walk under
        a seed depends on the agent only where it is in the way: a step that would come closer than `clearance_m` to the agent at
        `keep_clear_of` is barred.
        """
        pause, turn, choice = rng.random(3)
        if pause < params.pause_probability:
            return self
        free = [heading for heading in WAYS if self._free(heading, keep_clear_of, clearance_m)]
        if self.heading_deg in free and turn >= params.turn_probability:
            return replace(self, cell=self._next(self.heading_deg))
        ways = [heading for heading in free if heading != self.heading_deg] or free
        if not ways:
            return self
        heading = ways[int(choice * len(ways))]
        return Mover(self.roam, self._next(heading), heading)

    def _next(self, heading: HeadingDeg) -> Cell:
        columns, rows = WAYS[heading]
        return self.cell[0] + columns, self.cell[1] + rows

    def _free(self, heading: HeadingDeg, agent: Point | None, clearance_m: float) -> bool:
        cell = self._next(heading)
        if cell not in self.roam.cells:
            return False
        if agent is None:
            return True
        then_m = math.dist(self.roam.at(cell), agent)
        return then_m >= clearance_m or then_m >= math.dist(self.position, agent)


def walk(mover: Mover, params: MoverParams, rng: np.random.Generator, steps: int) -> Iterator[Mover]:
    """The mover after each of `steps` agent actions with no agent in its way."""
    for _ in range(steps):
        mover = mover.advance(params, rng)
        yield mover
