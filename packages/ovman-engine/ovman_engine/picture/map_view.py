"""The map view: a scene from above. World frame as in `floorplan`.

Source: AI2-THOR 5.0.0, ToggleMapView and GetMapViewCameraProperties (contract, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ovman_engine.plan.vector import vector

if TYPE_CHECKING:
    from ovman_engine.picture.camera import Onlooker, View
    from ovman_engine.world.world import World

DOWN_DEG = 90.0
CLEAR_M = 0.12
"""Height of the camera above the scene: a little more than its near plane."""


@dataclass(frozen=True)
class MapView:
    """An orthographic camera that looks straight down, with +z up in its image."""

    position: tuple[float, float, float]
    """metres"""
    half_m: float
    """Half the height of the image, metres"""

    @staticmethod
    def of(world: World) -> MapView:
        """Return the map view of a world: above the middle of its bounds, half as high as their longer side."""
        low, high = world.bounds()
        x, _, z = (low + high) / 2
        return MapView((float(x), float(high[1]) + CLEAR_M, float(z)), float(max(high[0] - low[0], high[2] - low[2])) / 2)

    def view(self, width: int, height: int, near_m: float, far_m: float, onlooker: Onlooker) -> View:
        """Its view in an image of `width` x `height` pixels."""
        from ovman_engine.picture.camera import View

        return View(
            np.array(self.position),
            0.0,
            DOWN_DEG,
            width=width,
            height=height,
            near_m=near_m,
            far_m=far_m,
            orthographic_size=self.half_m,
            onlooker=onlooker,
        )

    def properties(self) -> dict[str, Any]:
        """Its properties as arguments of AddThirdPartyCamera."""
        return {
            "position": vector(*self.position),
            "rotation": vector(DOWN_DEG, 0.0, 0.0),
            "orthographicSize": self.half_m,
            "orthographic": True,
        }
