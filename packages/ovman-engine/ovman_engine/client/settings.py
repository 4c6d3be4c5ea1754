"""What Initialize sets, and every later action goes by until the next Reset."""

from __future__ import annotations

from dataclasses import dataclass

from ovman_engine.bodies.embodiment import ActionNoise
from ovman_engine.paint.decor import Decor


@dataclass(frozen=True)
class Settings:
    """Defaults are AI2-THOR's."""

    grid_m: float = 0.25
    """Length of a move that names none, and spacing of the grid that positions snap to."""
    snap_to_grid: bool = True
    turn_deg: float = 90.0
    """Angle of a rotation that names none."""
    field_of_view_deg: float = 90.0
    """Vertical."""
    visibility_m: float = 1.5
    """How near an object must be to count as visible."""
    visibility_scheme: str = "Collider"
    """How nearness is judged: "Collider" or "Distance"."""
    near_m: float = 0.1
    far_m: float = 20.0
    look_up_deg: float = 30.0
    look_down_deg: float = 60.0
    """Largest pitch of the camera above and below the horizon."""
    noise: ActionNoise | None = None
    """How the agent's motions err."""
    agent_visible: bool = True
    """Whether cameras besides the agent's own see it."""
    depth: bool = False
    instances: bool = False
    classes: bool = False
    normals: bool = False
    fast_emit: bool = True
    """An event in which nothing changed but the action's outcome may be sent as a patch of the one before."""
    shown: frozenset[str] | None = None
    """Ids of the objects that the metadata list; None for all."""
    decor: Decor = Decor()
    """How the scene is painted and lit."""


@dataclass(frozen=True)
class Images:
    """The kinds of image that an event carries."""

    colour: bool = False
    depth: bool = False
    instances: bool = False
    classes: bool = False
    normals: bool = False

    @property
    def any(self) -> bool:
        return self.colour or self.depth or self.instances or self.classes or self.normals
