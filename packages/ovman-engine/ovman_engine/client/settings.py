"""Settings of Initialize, which hold until the next Reset."""

from __future__ import annotations

from dataclasses import dataclass

from ovman_engine.bodies.embodiment import ActionNoise
from ovman_engine.paint.decor import Decor


@dataclass(frozen=True)
class Settings:
    """All settings; the defaults are AI2-THOR's."""

    grid_m: float = 0.25
    """Default length of a move, and spacing of the grid to which positions snap."""
    snap_to_grid: bool = True
    turn_deg: float = 90.0
    """Default angle of a rotation."""
    field_of_view_deg: float = 90.0
    """Vertical field of view."""
    visibility_m: float = 1.5
    """Largest distance of a visible object."""
    visibility_scheme: str = "Collider"
    """How that distance is measured: "Collider" or "Distance"."""
    near_m: float = 0.1
    far_m: float = 20.0
    look_up_deg: float = 30.0
    look_down_deg: float = 60.0
    """Largest pitch of the camera above (look_up_deg) and below the horizon."""
    noise: ActionNoise | None = None
    """Noise of the agent's motion; None for none."""
    agent_visible: bool = True
    """Whether cameras other than the agent's own show the agent."""
    depth: bool = False
    instances: bool = False
    classes: bool = False
    normals: bool = False
    fast_emit: bool = True
    """Whether an event may be sent as a patch of the one before if only the action's outcome differs."""
    shown: frozenset[str] | None = None
    """objectIds that metadata list; None for all."""
    decor: Decor = Decor()
    """Materials, colours and lights in place of the scene's own."""


@dataclass(frozen=True)
class Images:
    """Which kinds of image an event carries."""

    colour: bool = False
    depth: bool = False
    instances: bool = False
    classes: bool = False
    normals: bool = False

    @property
    def any(self) -> bool:
        """Whether the event carries any image."""
        return self.colour or self.depth or self.instances or self.classes or self.normals
