"""The light of a visit."""

from __future__ import annotations

from ovman.models.sensors import Light
from ovman.sim.session import Session


def illuminate(session: Session, light: Light | None) -> None:
    """Give the scene that was just reset its light of the visit; None leaves its own. SimulatorError if the simulator refuses.

    Every range of AI2-THOR's action has equal ends, so that nothing is left to its draws.
    """
    if light is not None:
        session.step(
            "RandomizeLighting",
            synchronized=True,
            randomizeColor=True,
            brightness=[light.brightness] * 2,
            hue=[light.hue] * 2,
            saturation=[light.saturation] * 2,
        )
