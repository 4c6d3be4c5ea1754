"""Kinds of agent: the capsule, the camera and the noise of their motion.

Heights are relative to the agent's position, in metres. The feet of both of AI2-THOR's embodiments are 0.9 m below it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ActionNoise:
    """Normal distributions (mean, standard deviation) of the errors of a motion, metres and degrees.

    A rotation has the error `turn`. A move has the error `move` along its way, after a rotation with half the spread of `turn`.
    """

    move: tuple[float, float] = (0.001, 0.005)
    turn: tuple[float, float] = (0.0, 0.5)

    @property
    def swerve(self) -> tuple[float, float]:
        """Distribution of the rotation before a move."""
        return self.turn[0], self.turn[1] / 2


@dataclass(frozen=True)
class Embodiment:
    """One agentMode of AI2-THOR."""

    mode: str
    radius_m: float
    height_m: float
    """Height of the capsule with its hemispherical ends"""
    centre_m: float
    """Height of the capsule's centre"""
    standing_camera_m: float
    crouching_camera_m: float | None
    """Height of the camera when crouching; None for an agent that cannot crouch"""
    field_of_view_deg: float
    """Default vertical field of view"""
    strafes: bool
    noise: ActionNoise | None
    """Default noise; None for an exact agent"""

    @property
    def crouches(self) -> bool:
        """Whether the agent can crouch."""
        return self.crouching_camera_m is not None

    @property
    def foot_m(self) -> float:
        """Height of the lower end of the capsule."""
        return self.centre_m - self.height_m / 2

    def camera_m(self, standing: bool) -> float:
        """Height of the camera."""
        return self.standing_camera_m if standing or self.crouching_camera_m is None else self.crouching_camera_m

    def axis(self, foot: float) -> tuple[float, float]:
        """Heights of the ends of the capsule's axis if the capsule's lower end is at the height `foot`."""
        return foot + self.radius_m, foot + self.height_m - self.radius_m


DEFAULT = Embodiment("default", 0.2, 1.8, 0.0, 0.675, 0.0, 90.0, True, None)
LOCOBOT = Embodiment("locobot", 0.175, 0.9, -0.45, -0.0312, None, 60.0, False, ActionNoise())

EMBODIMENTS = {e.mode: e for e in (DEFAULT, LOCOBOT)} | {"bot": LOCOBOT}
"""By agentMode in lower case. "bot" is a former name of the locobot."""
