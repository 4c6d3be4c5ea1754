"""What the function of an arm is given: `AgentContext` for an agent that drives, `PredictionContext` for one that predicts.

The evaluator implements both (`ovman.evaluation.context`). What an arm's entry in config.yaml does not ask for raises ValueError,
in one line that says what to write.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from ovman.agents.interface.observation import Visit
from ovman.records.prediction import Abstention, Answer
from ovman.records.sighting import VisitPair
from ovman.settings import Need, Settings

if TYPE_CHECKING:
    from ovman.agents.pilot import Pilot
    from ovman.perception.clusters import Cluster
    from ovman.perception.detected import Detected
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder
    from ovman.perception.object_map import ObjectMap
    from ovman.records.world_state import WorldState

Made = TypeVar("Made")


class Mapper(Protocol):
    """From a visit to the clusters of its map."""

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of a visit's map. ValueError for a visit of which no map was made."""


@dataclass(frozen=True, slots=True)
class PrivilegedAnswer:
    """The answer, for the arm that is given it: a floor-plane point in metres, and for MOVING the name under which observations
    carry the target, else None."""

    answer: tuple[float, float]
    follow: str | None


class AgentContext(Protocol):
    """For an agent that drives one episode under one seed."""

    @property
    def rng(self) -> np.random.Generator:
        """Draws of this arm, episode and seed."""

    @property
    def settings(self) -> Settings:
        """Sections camera and primitives, and what the arm's entry names; another setting raises AttributeError."""

    @property
    def pilot(self) -> Pilot:
        """Drives to a point, as the reference agent does."""

    @property
    def mapper(self) -> Mapper:
        """From a recorded visit to the clusters of its map. For an arm that needs maps."""

    @property
    def privileged(self) -> PrivilegedAnswer | None:
        """The answer, for an arm that is given it."""

    @property
    def answered(self) -> Answer | Abstention | None:
        """What the static arm that this arm `executes` answered, as its prediction has it; None where that is not at hand.

        An agent may drive there instead of deciding again.
        """

    def detections(self, visit: Visit) -> Detected:
        """The detections in the frames of a recorded visit. For an arm that needs detections."""

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """What was made of the scene, read once by `read`. For an arm that needs it."""

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase. For an arm that needs maps, detections, segments or networks."""

    def networks(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. For an arm that needs networks."""


class PredictionContext(Protocol):
    """For an arm that predicts a point: what was recorded of an episode's two visits. `which` is "first" or "second"."""

    @property
    def rng(self) -> np.random.Generator:
        """Draws of this arm, episode and run."""

    @property
    def run(self) -> int:
        """0 for the first of the arm's `runs`."""

    @property
    def settings(self) -> Settings:
        """Sections camera and primitives, and what the arm's entry names; another setting raises AttributeError."""

    @property
    def reachable(self) -> np.ndarray:
        """(2, 2): two corners of the box around what can be reached in the second visit, metres."""

    @property
    def visits(self) -> VisitPair[str]:
        """Names under which files hold what was made of the visits. They reveal the change: use them for look-up alone."""

    @property
    def privileged_grounding(self) -> bool:
        """Whether the arm is told which objects the noun means (`true_objects`)."""

    def map(self, which: str) -> ObjectMap:
        """The reference agent's map of a visit. For an arm that needs maps."""

    def detections(self, which: str) -> Detected:
        """The detections in the frames of a visit. For an arm that needs detections."""

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """What was made of the scene, read once by `read`. For an arm that needs it."""

    def tour(self, which: str) -> Visit:
        """The frames of a visit. For an arm that needs tours."""

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase. For an arm that needs maps, dualmap, detections, segments or networks."""

    def networks(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. For an arm that needs networks."""

    def true_objects(self, objects: ObjectMap, *visits: str) -> tuple[int, ...]:
        """Indices of the objects that truly are of the query's category, in a map that was made of these visits in their order.

        What that means is the arm's `reading`: by what their detections show, or by the places of the instances. For an arm that
        is given its grounding.
        """

    def world(self, which: str) -> WorldState:
        """The instances of the query's category as a visit recorded them. For an arm that is given positions."""
