"""What an agent under evaluation is given and what it gives back.

Truth stays on the evaluator's side of this door: an agent sees observations and the query, never an episode, an answer, an
instance identity that spans visits, or anything of the world that it did not observe.

Frames: Unity's world frame, left-handed, y up, metres; yaw 0 looks along +z and 90 along +x; a positive horizon looks down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    import numpy as np

    from ovman.task import Query


VISITS = ("first", "second")
"""What records call the two visits of an episode."""


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


@dataclass(frozen=True, slots=True)
class CameraPose:
    """Where a frame was taken: the camera's position in metres, its yaw in degrees clockwise seen from above, and its horizon."""

    x: float
    y: float
    z: float
    yaw_deg: float
    horizon_deg: float


@dataclass(frozen=True, slots=True)
class Sighting:
    """One instance in one frame, for the arms that are handed positions.

    instance: a name that holds within one visit and says nothing about the other; x, z: its floor-plane position in metres at
    this frame.
    """

    instance: str
    category: str
    x: float
    z: float


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """One frame.

    rgb: (H, W, 3) uint8. depth: (H, W) float32, metres along the optical axis. Both have row 0 at the top and share the camera:
    its vertical field of view is field_of_view_deg, its pixels are square. Either is None for an arm that takes no images, for
    which nothing is drawn. last_action_succeeded: False where the last move was blocked; True in a tour. positions: the
    instances of this frame for an arm that is handed positions, None for every other arm. reachable: (K, 2) positions in metres
    that can be reached now, where the world goes on changing (MOVING); None where those that were given last still hold.
    """

    rgb: np.ndarray | None
    depth: np.ndarray | None
    pose: CameraPose
    field_of_view_deg: float
    last_action_succeeded: bool = True
    positions: tuple[Sighting, ...] | None = None
    reachable: np.ndarray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Visit:
    """One tour of the home: its frames in the order they were taken, and the positions (K, 2) that the agent can reach in it.

    The frames of a recorded tour are read when they are looked at. reachable is in metres on the floor plane (x, z), spaced by
    one step, recomputed after the change for the second visit. content: a digest of the frames and camera poses, by which an
    agent finds again what it made of them; None where nobody took it.
    """

    observations: Sequence[Observation]
    reachable: np.ndarray
    content: str | None = None


@runtime_checkable
class Agent(Protocol):
    """An agent under evaluation, called in this order for every episode: familiarise, revisit, ask, then act until it ends.

    One object serves many episodes one after another; ``familiarise`` starts a new one, and what was kept of the last is to be
    forgotten. An agent that looks at nothing while it drives says so with an attribute `looks` that is False: `act` gets poses
    without images, and nothing is drawn for it. An agent that says nothing gets images at every step. An exception raised by any
    of these ends the run of the evaluation, not the episode: an agent that cannot decide returns ABSTAIN.
    """

    def familiarise(self, visit: Visit) -> None:
        """The tour of the home before the change."""

    def revisit(self, visit: Visit) -> None:
        """The same tour after the change, which the agent did not see happen."""

    def ask(self, query: Query) -> None:
        """The category and the change relation that name the goal. Nothing was known of it during the tours."""

    def act(self, observation: Observation) -> Action:
        """The next primitive, given the frame at the present pose. The first call comes at the spawn.

        Called until STOP or ABSTAIN is returned or the action budget is spent, which is a failure.
        """
