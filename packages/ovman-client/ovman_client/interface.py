"""What an agent is given and what it gives back. Frames are in Unity's world: left-handed, y up, metres.

Yaw 0 looks along +z and 90 along +x; a positive horizon looks down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np


class Action(str, Enum):
    """What an agent may do. STOP asks to be judged where it stands; ABSTAIN says that it cannot decide, which is a failure."""

    MOVE_AHEAD = "MoveAhead"
    ROTATE_LEFT = "RotateLeft"
    ROTATE_RIGHT = "RotateRight"
    STOP = "Stop"
    ABSTAIN = "Abstain"


@dataclass(frozen=True)
class Camera:
    """Of all frames: their size in pixels and the vertical field of view in degrees; pixels are square."""

    width: int
    height: int
    field_of_view_deg: float


@dataclass(frozen=True)
class CameraPose:
    """Where a frame is taken: the camera's position in metres, its yaw in degrees clockwise seen from above, and its horizon."""

    x: float
    y: float
    z: float
    yaw_deg: float
    horizon_deg: float


@dataclass(frozen=True, eq=False)
class Observation:
    """One frame.

    rgb: (H, W, 3) uint8. depth: (H, W) float32, metres along the optical axis. Both are None for an agent that takes no images.
    last_action_succeeded: False where the last move was blocked; True in a tour. reachable: (K, 2) positions in metres that can
    be reached now, where the world changes while the agent acts; None where the positions given last still hold.
    """

    rgb: np.ndarray | None
    depth: np.ndarray | None
    pose: CameraPose
    field_of_view_deg: float
    last_action_succeeded: bool
    reachable: np.ndarray | None


@dataclass(frozen=True, eq=False)
class Visit:
    """One tour of the home: its frames in the order they were taken, and the positions (K, 2) in metres that can be reached.

    content: a digest of the frames and poses; tours that look the same have the same.
    """

    observations: Sequence[Observation]
    reachable: np.ndarray
    content: str | None


@dataclass(frozen=True)
class Instruction:
    """A request of the words track: a sentence, and its noun phrase without article."""

    sentence: str
    phrase: str


@dataclass(frozen=True)
class Query:
    """A request of the paper's track, with the words of an `Instruction`.

    category: such as "Chair". relation: moved, former, moving, stable, appeared or removed.
    """

    category: str
    relation: str
    sentence: str = ""
    phrase: str = ""


@dataclass(frozen=True, eq=False)
class Context:
    """What an agent is made with, once a run.

    rng: draws of this run alone; an agent that draws from nothing else repeats its runs exactly. step_m, turn_deg: what one move
    and one turn do. action_budget: actions of a run. stall_after: actions without a successful move that end it. words: 64-bit
    words by name, from which draws follow; rng is seeded by "picks".
    """

    rng: np.random.Generator
    step_m: float
    turn_deg: float
    action_budget: int
    stall_after: int
    camera: Camera
    words: dict[str, list[int]]
