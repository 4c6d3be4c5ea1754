"""What a form is made for: type, size, asset and the evidence of its surroundings, without the floor plan itself."""

from __future__ import annotations

from dataclasses import dataclass

from ovman.engine.shapes.style import Style


@dataclass(frozen=True)
class Subject:
    """The object to be formed, in its own frame: x to the sides, y up from 0 to h, z from the back -d/2 to the front d/2; metres."""

    type: str
    w: float
    h: float
    d: float
    style: Style
    inserts: tuple[tuple[float, float, float, float], ...] = ()
    """Fronts of drawers, doors and shelves that are objects of their own within it: (x low, x high, y low, y high)."""
    hung: bool = False
    """It hangs on a wall or stands within something else, so nothing has to carry it from below."""

    @property
    def x(self) -> float:
        """Half its width."""
        return self.w / 2

    @property
    def z(self) -> float:
        """Half its depth."""
        return self.d / 2
