"""Embodiments: AI2-THOR's agent mode, its camera, its step and its turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ovman.settings import Settings

UNSEEN_M = 0.01
"""Visibility distance given to the simulator, which refuses 0; visibility is judged by masks instead."""


@dataclass(frozen=True)
class Embodiment:
    """A body with a camera.

    width_px, height_px: of the frames; field_of_view_deg: vertical. step_m: length of MoveAhead; turn_deg: angle of RotateLeft.
    mode: AI2-THOR's agentMode, "default" or "locobot"; noisy: whether its moves and turns are inexact. instances: whether images
    come with instance segmentation; RGB and depth always do.
    """

    width_px: int
    height_px: int
    field_of_view_deg: float
    step_m: float
    turn_deg: float
    mode: str = "default"
    noisy: bool = False
    instances: bool = True

    @staticmethod
    def of(constants: Settings) -> Embodiment:
        """Return the embodiment of the benchmark. constants: must own camera.*, primitives.step_m and primitives.turn_deg."""
        camera, primitives = constants.camera, constants.primitives
        return Embodiment(camera.width_px, camera.height_px, camera.field_of_view_deg, primitives.step_m, primitives.turn_deg)

    @staticmethod
    def named(name: str, constants: Settings) -> Embodiment:
        """Return the embodiment that an arm names: "default", that of the benchmark, or "locobot", that of CoW.

        constants: as for `of`; for "locobot" they must own locobot.* as well. ValueError for another name.
        """
        own = Embodiment.of(constants)
        if name == "default":
            return own
        if name == "locobot":
            side_px, field_of_view_deg = constants.locobot.side_px, constants.locobot.field_of_view_deg
            return replace(
                own, width_px=side_px, height_px=side_px, field_of_view_deg=field_of_view_deg, mode="locobot", noisy=True
            )
        raise ValueError(f"{name!r} is not an embodiment; there are default and locobot")

    def initialization(self) -> dict[str, Any]:
        """Parameters of the Controller; AI2-THOR restores them at every reset."""
        given: dict[str, Any] = {
            "fieldOfView": self.field_of_view_deg,
            "gridSize": self.step_m,
            # Turns other than quarters are refused on a grid.
            "snapToGrid": False,
            "rotateStepDegrees": self.turn_deg,
            "renderDepthImage": True,
            "renderInstanceSegmentation": self.instances,
            # At the initialisation alone; later steps ask for images themselves.
            "renderImage": False,
            # Masks tell what is seen; the computation of "visible" may take longer than the rest of a step.
            "visibilityDistance": UNSEEN_M,
        }
        if self.mode != "default":
            given |= {"agentMode": self.mode, "applyActionNoise": self.noisy}
        return given

    def seen_by(self, camera: Embodiment, mask: np.ndarray) -> np.ndarray:
        """Return a mask (H, W) of this camera's frame resampled to the frame of `camera` at the same pose, by nearest pixels.

        Pixel counts then do not depend on the embodiment. Pixels that this camera does not see are False.
        """
        if (self.height_px, self.width_px, self.field_of_view_deg) == (
            camera.height_px,
            camera.width_px,
            camera.field_of_view_deg,
        ):
            return mask
        # Tangents of the rays through the middles of the pixels; pixels are square, the field of view is vertical.
        wide, own = (2.0 * math.tan(math.radians(c.field_of_view_deg) / 2.0) / c.height_px for c in (camera, self))
        axes = []
        for theirs, ours in ((camera.height_px, self.height_px), (camera.width_px, self.width_px)):
            tangents = (np.arange(theirs) + 0.5 - theirs / 2.0) * wide
            axes.append(np.floor(tangents / own + ours / 2.0).astype(int))
        rows, columns = axes
        inside = ((rows >= 0) & (rows < self.height_px))[:, None] & ((columns >= 0) & (columns < self.width_px))
        found: np.ndarray = mask[np.clip(rows, 0, self.height_px - 1)][:, np.clip(columns, 0, self.width_px - 1)] & inside
        return found
