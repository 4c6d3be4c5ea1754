"""The one place that starts a simulator. Everything after it is the same for the embedded engine and for Unity."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ai2thor.controller import Controller

BACKENDS = ("embedded", "thor")


def start(
    backend: str, scene: str, width_px: int, height_px: int, field_of_view_deg: float, step_m: float, turn_deg: float
) -> Controller:
    """A running ai2thor Controller on `scene`.

    `backend` is "embedded" (this project's engine, CPU) or "thor" (the Unity build through CloudRendering, GPU). Frames are
    `width_px` x `height_px` with a vertical field of view in degrees; MoveAhead goes `step_m` metres, RotateLeft turns
    `turn_deg`. Raises ValueError for another backend.
    """
    from ai2thor.controller import Controller

    shared: dict[str, Any] = {
        "scene": scene,
        "width": width_px,
        "height": height_px,
        "fieldOfView": field_of_view_deg,
        "gridSize": step_m,
        "snapToGrid": False,
        "rotateStepDegrees": turn_deg,
        "renderDepthImage": True,
        "renderInstanceSegmentation": True,
        # Of the initialisation alone: a world that was just reset is looked at when it is as it should be.
        "renderImage": False,
    }
    if backend == "embedded":
        from ovman.engine import executable

        # The client asks for Vulkan if it sees a GPU.
        hidden = os.environ.pop("CUDA_VISIBLE_DEVICES", None)
        try:
            return Controller(local_executable_path=executable(), **shared)
        finally:
            if hidden is not None:
                os.environ["CUDA_VISIBLE_DEVICES"] = hidden
    if backend == "thor":
        from ai2thor.platform import CloudRendering

        return Controller(platform=CloudRendering, **shared)
    raise ValueError(f"benchmark.backend: {backend!r} is not one of {', '.join(BACKENDS)}")
