"""What an agent observes, and what it does. Frames are in Unity's world: left-handed, y up, metres.

Yaw 0 looks along +z and 90 along +x; a positive horizon looks down.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

VISITS = ("first", "second")
"""The names of the two visits of an episode."""


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


@dataclass(frozen=True, slots=True)
class CameraPose:
    """Where a frame is taken: the camera's position in metres, its yaw in degrees clockwise seen from above, and its horizon."""

    x: float
    y: float
    z: float
    yaw_deg: float
    horizon_deg: float


@dataclass(frozen=True, slots=True)
class SeenInstance:
    """One instance in one frame, for the arms that are given positions.

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
    its vertical field of view is field_of_view_deg, its pixels are square. Either is None for an arm that takes no images.
    last_action_succeeded: False where the last move was blocked; True in a tour. positions: the instances of this frame for an
    arm that is given positions, None for every other arm. reachable: (K, 2) positions in metres that can be reached now, where
    the world changes while the agent acts (MOVING); None where the positions given last still hold.
    """

    rgb: np.ndarray | None
    depth: np.ndarray | None
    pose: CameraPose
    field_of_view_deg: float
    last_action_succeeded: bool = True
    positions: tuple[SeenInstance, ...] | None = None
    reachable: np.ndarray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Visit:
    """One tour of the home: its frames in the order they were taken, and the positions (K, 2) that the agent can reach in it.

    The frames of a recorded tour are read when they are indexed. reachable is in metres on the floor plane (x, z), spaced by one
    step, recomputed after the change for the second visit. content: a digest of the frames and camera poses, by which an agent
    finds what it made of them earlier; None where it is not known.
    """

    observations: Sequence[Observation]
    reachable: np.ndarray
    content: str | None = None
