"""The light of a visit."""

from __future__ import annotations

from ovman.records.sensors import Light
from ovman.sim.session import Session


def illuminate(session: Session, light: Light | None) -> None:
    """Give the scene that was just reset its light of the visit; None leaves its own. SimulatorError if the simulator refuses.

    Every range of AI2-THOR's action has equal ends, so that nothing is left to its draws; those of materials have a seed.
    """
    if light is not None:
        if light.materials is not None:
            session.step("SetRandomSeed", seed=light.materials)
            session.step("RandomizeMaterials")
        session.step(
            "RandomizeLighting",
            synchronized=True,
            randomizeColor=True,
            brightness=[light.brightness] * 2,
            hue=[light.hue] * 2,
            saturation=[light.saturation] * 2,
        )
