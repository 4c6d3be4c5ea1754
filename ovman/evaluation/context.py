"""What the function that an arm names is given: `Given` for an agent that drives, `Recorded` for one that predicts a point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.pilot import Pilot
from ovman.agents.reference.object_map import ObjectMap
from ovman.evaluation.observation_store import Senses
from ovman.evaluation.privileged_grounding import grounding_by_truth, recorded_positions
from ovman.models.settings import Arm, Need, Settings, Source
from ovman.sim.recorded import world_state
from ovman.task import WorldState

if TYPE_CHECKING:
    from ovman.agents.reference.mapper import Mapper
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")


@dataclass(frozen=True, slots=True)
class Told:
    """The answer, for the arm that is handed it: a floor-plane point in metres, and for MOVING the name under which observations
    carry the target."""

    answer: tuple[float, float]
    follow: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """For an agent that drives one episode under one seed.

    rng: draws of this arm, episode and seed. constants: those of the stage `executions` and those that the arm's entry names.
    pilot: the way to a point, as the reference agent drives it. told: None but for the oracle. senses: behind the methods.
    """

    rng: np.random.Generator
    constants: Settings
    pilot: Pilot
    senses: Senses
    told: Told | None = None

    @property
    def mapper(self) -> Mapper:
        """From a recorded visit to the clusters of its map. For an arm that needs maps."""
        return self.senses.mapper

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase. For an arm that needs maps or networks."""
        return self.senses.noun(phrase)

    def sight(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. For an arm that needs networks."""
        return self.senses.sight


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """For an arm that predicts a point: what was recorded of an episode's two visits, `which` of them is "first" or "second".

    rng: draws of this arm, episode and run; run: 0 for the first of `runs`. constants: those of the stage `predictions` and those
    that the arm's entry names. reachable (2, 2): two corners of the box around what can be reached in the second visit, metres.
    visits: the names under which files have what was made of the visits; they tell what was changed, and an agent uses them for
    nothing but to look that up. category: the query's; sightings: by visit, of the instances of that category, for an arm that is
    handed its grounding or positions, else None.
    """

    rng: np.random.Generator
    run: int
    constants: Settings
    reachable: np.ndarray
    visits: Mapping[str, str]
    category: str
    arm: Arm
    senses: Senses
    sightings: Mapping[str, Sequence[Mapping[str, Any]]] | None = None

    @property
    def grounding(self) -> Source:
        """Whether the arm is handed its grounding."""
        return self.arm.grounding

    def map(self, which: str) -> ObjectMap:
        """The reference agent's map of a visit. For an arm that needs maps."""
        return self.senses.perceived.map(self.visits[which])

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """What was made of the scene, read once by `read`. For an arm that needs it."""
        return self.senses.made(need, read)

    def tour(self, which: str) -> Visit:
        """The frames of a visit. For an arm that needs tours."""
        return self.senses.visit(self.visits[which], self.reachable)

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase. For an arm that needs maps, dualmap or networks."""
        return self.senses.noun(phrase)

    def sight(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. For an arm that needs networks."""
        return self.senses.sight

    def true_objects(self, which: str, p: np.ndarray) -> tuple[int, ...]:
        """Which of the map objects at p (N, 2) stand for instances of the query's category in a visit.

        For an arm that is handed its grounding. ValueError for any other.
        """
        sightings = self._handed(self.arm.grounding, "grounding")[which]
        min_mask_px, radius_m = self.constants.admissibility.min_mask_px, self.constants.success.radius_m
        return grounding_by_truth(recorded_positions(sightings, min_mask_px), p, radius_m)

    def world(self, which: str) -> WorldState:
        """The instances of the query's category as a visit recorded them. For an arm that is handed positions."""
        sightings = self._handed(self.arm.positions, "positions")[which]
        return world_state(sightings, self.category, self.constants.admissibility.min_mask_px)

    def _handed(self, source: Source, what: str) -> Mapping[str, Sequence[Mapping[str, Any]]]:
        if source is not Source.HANDED or self.sightings is None:
            raise ValueError(f"arms.{self.arm.name} finds its {what} itself; a diagnostic arm says {what}: handed in its entry")
        return self.sightings
