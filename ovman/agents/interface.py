"""The interface of an agent: what it is given and what it gives back.

The evaluator keeps the truth: an agent gets observations and the query, and no episode, answer or identity of an instance across
visits. In the words track the query is an `Instruction`, without category and relation. Frames are in Unity's world: left-handed,
y up, metres. Yaw 0 looks along +z and 90 along +x; a positive horizon looks down.

`ovman.evaluation.context` implements the two contexts. What an arm's entry does not ask for raises ValueError, in one line that
says what to write.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar, runtime_checkable

import numpy as np

from ovman.language import noun, sentence
from ovman.perception.backprojection import Camera
from ovman.records.prediction import Abstention, AbstentionReason, Answer, Evidence, Predicted, UniformBox, UniformPick
from ovman.records.task import Relation
from ovman.records.visit import VisitPair
from ovman.settings import Need, Settings

if TYPE_CHECKING:
    from ovman.agents.pilot import Pilot
    from ovman.perception.clusters import Cluster, ObjectMap
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder
    from ovman.perception.records import Detected
    from ovman.records.task import WorldState

__all__ = [
    "LETTERS",
    "VISITS",
    "Abstention",
    "AbstentionReason",
    "Action",
    "Agent",
    "AgentContext",
    "Answer",
    "CameraPose",
    "Evidence",
    "Instruction",
    "Mapper",
    "Observation",
    "Predicted",
    "PredictionContext",
    "PrivilegedAnswer",
    "Query",
    "Relation",
    "SeenInstance",
    "UniformBox",
    "UniformPick",
    "Visit",
]

NOTHING_NAMED = "thing"
"""Stands in a sentence for a noun phrase that is withheld."""
VISITS = ("first", "second")
"""The names of the two visits of an episode."""

Artifact = TypeVar("Artifact")


class Action(StrEnum):
    """The primitives of the benchmark; a value that names an AI2-THOR action is that action.

    The step of a move and the angle of a turn are constants of the benchmark. STOP and ABSTAIN end the episode: STOP asks to be
    judged where the agent stands, ABSTAIN says that it cannot decide and is scored as a failure.
    """

    MOVE_AHEAD = "MoveAhead"
    ROTATE_LEFT = "RotateLeft"
    ROTATE_RIGHT = "RotateRight"
    STOP = "Stop"
    ABSTAIN = "Abstain"


LETTERS: Mapping[Action, str] = {
    Action.MOVE_AHEAD: "F",
    Action.ROTATE_LEFT: "L",
    Action.ROTATE_RIGHT: "R",
    Action.STOP: "S",
    Action.ABSTAIN: "A",
}
"""Actions as letters of a trace: forward, left, right, stop, abstain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruction:
    """A request in words. In the words track an agent gets nothing else.

    Attributes:
        sentence: Such as "Where did they move the couch to? Go and stand by it."
        phrase: The noun phrase of the sentence without article, "couch"; empty where it is withheld.
    """

    sentence: str
    phrase: str


@dataclass(frozen=True, slots=True)
class Query(Instruction):
    """A request of the paper's track, q = (c, rho). Its words are the category's noun and the canonical sentence.

    Attributes:
        category: Such as "Sofa"; empty where the noun is withheld, and where an agent read the query from an instruction.
        relation: The change relation.
    """

    category: str
    relation: Relation
    sentence: str = field(default="", kw_only=True)
    phrase: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Fill in the words."""
        phrase = self.phrase or (noun(self.category) if self.category else "")
        object.__setattr__(self, "phrase", phrase)
        object.__setattr__(self, "sentence", self.sentence or sentence(self.relation, phrase or NOTHING_NAMED))


@dataclass(frozen=True, slots=True)
class CameraPose:
    """The camera's position in metres, its yaw in degrees clockwise seen from above, and its horizon in degrees."""

    x: float
    y: float
    z: float
    yaw_deg: float
    horizon_deg: float


@dataclass(frozen=True, slots=True)
class SeenInstance:
    """One instance in one frame, for the arms that are given positions.

    Attributes:
        instance: A name that holds within one visit and says nothing about the other.
        category: The category of the instance.
        x: Floor-plane position at this frame, metres.
        z: Floor-plane position at this frame, metres.
    """

    instance: str
    category: str
    x: float
    z: float


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """One frame. Both images have row 0 at the top, square pixels and one camera; an arm that takes no images gets None.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32, metres along the optical axis.
        pose: The camera pose.
        field_of_view_deg: Vertical field of view of the camera.
        last_action_succeeded: False if the last move was blocked; True in a tour.
        positions: The instances of this frame for an arm that is given positions, None for every other arm.
        reachable: (K, 2) positions in metres that can be reached now, if the world changes while the agent acts (MOVING); None if
            the positions given last still hold.
    """

    rgb: np.ndarray | None
    depth: np.ndarray | None
    pose: CameraPose
    field_of_view_deg: float
    last_action_succeeded: bool = True
    positions: tuple[SeenInstance, ...] | None = None
    reachable: np.ndarray | None = None

    @property
    def camera(self) -> Camera:
        """Pose and lens, from which `ovman.perception.backprojection` computes positions."""
        at = self.pose
        return Camera((at.x, at.y, at.z), at.yaw_deg, at.horizon_deg, self.field_of_view_deg)


@dataclass(frozen=True, slots=True, eq=False)
class Visit:
    """One tour of the home.

    Attributes:
        observations: The frames in the order they were taken. Those of a recorded tour are read when they are indexed.
        reachable: (K, 2) positions (x, z) in metres that the agent can reach, spaced by one step, recomputed after the change for
            the second visit. On splits with the rule `grid: first` both visits have those of visit 1.
        content: Digest of the frames and camera poses, by which an agent finds what it made of them earlier; None if unknown.
    """

    observations: Sequence[Observation]
    reachable: np.ndarray
    content: str | None = None


@runtime_checkable
class Agent(Protocol):
    """An agent under evaluation, called in this order for every episode: familiarise, revisit, ask, then act until it ends.

    ``familiarise`` starts a new episode: an agent forgets what it kept of the last one. An agent that needs no images while it
    drives says so with an attribute `looks` that is False once ``ask`` has returned: `act` gets poses without images, and nothing
    is drawn for it. Without the attribute it gets images at every step. An exception raised by any of these ends the run of the
    evaluation, not the episode: an agent that cannot decide returns ABSTAIN.
    """

    def familiarise(self, visit: Visit) -> None:
        """Take the tour of the home before the change."""

    def revisit(self, visit: Visit) -> None:
        """Take the same tour after the change, which the agent did not see happen."""

    def ask(self, query: Instruction) -> None:
        """Take the goal: a `Query`, in the words track an `Instruction`. Nothing was known of it during the tours."""

    def act(self, observation: Observation) -> Action:
        """Return the next primitive, given the frame at the present pose. The first call comes at the spawn.

        Called until STOP or ABSTAIN is returned or the action budget is spent, which is a failure.
        """


Mapper = Callable[[Visit], "Sequence[Cluster]"]
"""From a visit to the clusters of its map. Raises ValueError for a visit of which no map was made."""


@dataclass(frozen=True, slots=True)
class PrivilegedAnswer:
    """The answer, for the arm that is given it.

    Attributes:
        answer: Floor-plane point in metres.
        follow: For MOVING the name under which observations carry the target, else None.
    """

    answer: tuple[float, float]
    follow: str | None


class Context(Protocol):
    """The inputs of every arm."""

    @property
    def rng(self) -> np.random.Generator:
        """Draws of this arm and episode, and of its seed or run."""

    @property
    def settings(self) -> Settings:
        """Sections camera and primitives, and what the arm's entry names; another setting raises AttributeError."""

    def made(self, need: Need, read: Callable[[Path], Artifact]) -> Artifact:
        """Return an artifact of the scene, read once by `read`. For an arm that needs it."""

    def noun(self, phrase: str) -> np.ndarray:
        """Return the unit embedding (K,) of a noun phrase. For an arm that needs more than tours."""

    def networks(self) -> tuple[Detector, Encoder]:
        """Return the detector and the encoder of section perception. For an arm that needs networks."""


class AgentContext(Context, Protocol):
    """The inputs of an agent that drives: one episode under one seed."""

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
        """The recorded prediction of the static arm that this arm `executes`; None if it is not at hand.

        An agent may drive there instead of deciding again.
        """

    def detections(self, visit: Visit) -> Detected:
        """Return the detections in the frames of a recorded visit. For an arm that needs detections."""


class PredictionContext(Context, Protocol):
    """What an arm that predicts a point is given: records of an episode's two visits. `which` is "first" or "second"."""

    @property
    def run(self) -> int:
        """0 for the first of the arm's `runs`."""

    @property
    def reachable(self) -> np.ndarray:
        """(2, 2): two corners of the box around what can be reached in the second visit, metres."""

    @property
    def spawn(self) -> np.ndarray:
        """(2,): where a run begins (x, z), metres, which an agent that drives learns at its first step."""

    @property
    def grid(self) -> np.ndarray:
        """(K, 2): positions that can be reached in the untouched scene, metres. For an arm that needs the scene."""

    @property
    def looks(self) -> Mapping[str, str]:
        """Looks of instances by their ids, equal for instances of one asset. For an arm that is given positions."""

    @property
    def visits(self) -> VisitPair[str]:
        """Names under which files hold what was made of the visits. They reveal the change: use them for look-up alone."""

    @property
    def privileged_grounding(self) -> bool:
        """Whether the arm is told which objects the noun means (`true_objects`)."""

    def map(self, which: str) -> ObjectMap:
        """Return the reference agent's map of a visit. For an arm that needs maps."""

    def detections(self, which: str) -> Detected:
        """Return the detections in the frames of a visit. For an arm that needs detections."""

    def true_detections(self, which: str) -> Detected:
        """Return the true masks of what can be moved in the frames of a visit, with embeddings of their crops.

        For an arm that needs networks and is given positions.
        """

    def tour(self, which: str) -> Visit:
        """Return the frames of a visit. For an arm that needs tours."""

    def true_objects(self, objects: ObjectMap, *visits: str) -> tuple[int, ...]:
        """Return the objects of a map of `visits` that truly are of the query's category. For an arm with oracle grounding.

        The arm's `reading` says what that means: by their detections, or by the places of the instances.
        """

    def world(self, which: str) -> WorldState:
        """Return the instances of the query's category as a visit recorded them. For an arm that is given positions."""
