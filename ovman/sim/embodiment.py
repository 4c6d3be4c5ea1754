"""What an agent is in the simulator: AI2-THOR's kind of body, its camera, its step and its turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ovman.models.settings import Settings

UNSEEN_M = 0.01
"""The simulator is told that nothing farther than this counts as visible; it takes no 0."""


@dataclass(frozen=True)
class Embodiment:
    """A body with a camera.

    Frames are `width_px` x `height_px` with a vertical field of view in degrees; MoveAhead goes `step_m` metres, RotateLeft turns
    `turn_deg`. `mode` is AI2-THOR's agentMode: "default", or "locobot", whose moves and turns are inexact where it is `noisy`.
    `instances`: whether images come with instance segmentation; RGB and depth always do.
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
        """The benchmark's own, from a stage's view that owns camera.*, primitives.step_m and primitives.turn_deg."""
        camera, primitives = constants.camera, constants.primitives
        return Embodiment(camera.width_px, camera.height_px, camera.field_of_view_deg, primitives.step_m, primitives.turn_deg)

    @staticmethod
    def named(name: str, constants: Settings) -> Embodiment:
        """The one that an arm names: "default", the benchmark's own, or "locobot", CoW's. The latter owns locobot.* as well.

        ValueError for another name.
        """
        own = Embodiment.of(constants)
        if name == "default":
            return own
        if name == "locobot":
            side_px, field_of_view_deg = constants.locobot.side_px, constants.locobot.field_of_view_deg
            return replace(
                own, width_px=side_px, height_px=side_px, field_of_view_deg=field_of_view_deg, mode="locobot", noisy=True
            )
        raise ValueError(f"{name!r} is no embodiment; there are default and locobot")

    def initialization(self) -> dict[str, Any]:
        """Parameters of the Controller that AI2-THOR keeps until they are given anew: a reset brings them back by itself."""
        given: dict[str, Any] = {
            "fieldOfView": self.field_of_view_deg,
            "gridSize": self.step_m,
            # Turns other than quarters are refused on a grid.
            "snapToGrid": False,
            "rotateStepDegrees": self.turn_deg,
            "renderDepthImage": True,
            "renderInstanceSegmentation": self.instances,
            # Of the initialisation alone: a world that was just reset is looked at when it is as it should be.
            "renderImage": False,
            # What is seen is told by masks. To find out who is "visible" may take longer than all else that a step does.
            "visibilityDistance": UNSEEN_M,
        }
        if self.mode != "default":
            given |= {"agentMode": self.mode, "applyActionNoise": self.noisy}
        return given

    def seen_by(self, camera: Embodiment, mask: np.ndarray) -> np.ndarray:
        """A mask (H, W) of this camera's frame as the frame of `camera` at the same pose has it, by nearest pixels.

        What is counted in pixels is then the same in the frames of any camera. What only `camera` sees is False.
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
