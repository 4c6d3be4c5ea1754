"""Third-party cameras. World frame as in `floorplan`.

Source: AI2-THOR 5.0.0, AddThirdPartyCamera and UpdateThirdPartyCamera (contract, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ovman_engine.plan.floorplan import euler_degrees, rotation_matrix
from ovman_engine.plan.vector import vector

if TYPE_CHECKING:
    from ovman_engine.picture.camera import Onlooker, View

Triple = tuple[float, float, float]

ORTHOGRAPHIC_M = 5.0
"""Default half height of an orthographic image: Unity's."""
EULER_DIGITS = 6
"""Decimals of reported angles in degrees: angles from matrices have the noise of double precision."""


@dataclass(frozen=True)
class ThirdPartyCamera:
    """One camera. Equal cameras draw equal images."""

    position: Triple
    """metres"""
    rotation: Triple
    """Unity's Euler angles (x, y, z) in degrees, applied in the order z, x, y; each in [0, 360), x within 90 of 0"""
    field_of_view_deg: float
    """Vertical"""
    near_m: float
    far_m: float
    orthographic: bool = False
    orthographic_m: float = ORTHOGRAPHIC_M
    """Half the height of an orthographic image, metres"""
    sky: tuple[int, int, int] | None = None
    """sRGB, 0 to 255, of pixels without a hit; None for the agent's sky"""

    def view(self, width: int, height: int, onlooker: Onlooker) -> View:
        """Its view in an image of `width` x `height` pixels."""
        from ovman_engine.picture.camera import View

        pitch, yaw, roll = self.rotation
        return View(
            np.array(self.position),
            yaw,
            pitch,
            self.field_of_view_deg,
            width,
            height,
            near_m=self.near_m,
            far_m=self.far_m,
            orthographic_size=self.orthographic_m if self.orthographic else None,
            roll_deg=roll,
            sky=self.sky,
            onlooker=onlooker,
        )

    def metadata(self, number: int) -> dict[str, Any]:
        """Its entry in the metadata's thirdPartyCameras."""
        return {
            "thirdPartyCameraId": number,
            "position": vector(*self.position),
            "rotation": vector(*self.rotation),
            "fieldOfView": float(self.field_of_view_deg),
        }


def normal_angles(degrees: np.ndarray) -> Triple:
    """Euler angles (3,) as Unity reports them for the same rotation."""
    x, y, z = np.round(euler_degrees(rotation_matrix(degrees)), EULER_DIGITS) % 360.0
    return float(x), float(y), float(z)
