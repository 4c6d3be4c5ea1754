"""What an agent is made of: the capsule that has to fit, the camera on it, and how exactly it does what it is told.

Heights are relative to the agent's position, in metres. Both embodiments of AI2-THOR stand with their feet 0.9 m below it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ActionNoise:
    """Normal distributions (mean, standard deviation) of what a motion adds to what it was asked for; metres and degrees.

    A rotation errs by `turn`; a move by `move` along its way, after a rotation by half the spread of `turn`.
    """

    move: tuple[float, float] = (0.001, 0.005)
    turn: tuple[float, float] = (0.0, 0.5)

    @property
    def swerve(self) -> tuple[float, float]:
        """The rotation that goes with a move."""
        return self.turn[0], self.turn[1] / 2


@dataclass(frozen=True)
class Embodiment:
    """One agentMode of AI2-THOR."""

    mode: str
    radius_m: float
    height_m: float
    """Of the whole capsule, its hemispherical ends included."""
    centre_m: float
    """Height of the capsule's middle."""
    standing_camera_m: float
    crouching_camera_m: float | None
    """Height of the camera when crouching; None for an agent that does not."""
    field_of_view_deg: float
    """Vertical, unless Initialize says otherwise."""
    strafes: bool
    noise: ActionNoise | None
    """How it errs unless Initialize says otherwise; None for an agent that does not."""

    @property
    def crouches(self) -> bool:
        return self.crouching_camera_m is not None

    @property
    def foot_m(self) -> float:
        """Height of the capsule's lower end."""
        return self.centre_m - self.height_m / 2

    def camera_m(self, standing: bool) -> float:
        """Height of the camera."""
        return self.standing_camera_m if standing or self.crouching_camera_m is None else self.crouching_camera_m

    def axis(self, foot: float) -> tuple[float, float]:
        """Heights of the ends of the capsule's axis if its lower end is at the height `foot`."""
        return foot + self.radius_m, foot + self.height_m - self.radius_m


DEFAULT = Embodiment("default", 0.2, 1.8, 0.0, 0.675, 0.0, 90.0, True, None)
LOCOBOT = Embodiment("locobot", 0.175, 0.9, -0.45, -0.0312, None, 60.0, False, ActionNoise())

EMBODIMENTS = {e.mode: e for e in (DEFAULT, LOCOBOT)} | {"bot": LOCOBOT}
"""By agentMode in lower case; "bot" is a former name of the locobot's."""
