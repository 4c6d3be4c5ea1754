"""A room of coloured boxes and what a camera sees of it, by intersecting rays: pictures whose truth is known exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ovman.perception.backprojection import Camera
from ovman.perception.tour_files import View


@dataclass(frozen=True)
class Box:
    """An axis-aligned box in Unity's world, metres: least and greatest (x, y, z); class_id is in the red of its colour."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    class_id: int

    @property
    def centre(self) -> tuple[float, float, float]:
        return tuple((np.array(self.low) + self.high) / 2)


def view(boxes: list[Box], camera: Camera, width: int = 64, height: int = 48) -> View:
    """What a camera sees: red 10 (class_id + 1) where a box is; no colour and no depth where there is none."""
    focal = height / 2 / math.tan(math.radians(camera.field_of_view_deg) / 2)
    rows, columns = np.indices((height, width)) + 0.5
    local = np.stack([(columns - width / 2) / focal, (height / 2 - rows) / focal, np.ones_like(rows)], axis=-1)
    rays = local @ camera.axes().T
    eye = np.array(camera.position)
    rgb, depth = np.zeros((height, width, 3), np.uint8), np.full((height, width), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for box in boxes:
            near = np.minimum((box.low - eye) / rays, (box.high - eye) / rays).max(axis=-1)
            far = np.maximum((box.low - eye) / rays, (box.high - eye) / rays).min(axis=-1)
            hit = (near <= far) & (near > 0) & (near < depth)
            depth[hit], rgb[hit, 0] = near[hit], 10 * (box.class_id + 1)
    return View(rgb, np.where(np.isfinite(depth), depth, 0.0).astype(np.float32), camera)


def spin(x: float, z: float, step_deg: float = 30.0, horizon_deg: float = 20.0) -> list[Camera]:
    """The cameras of one turn on the spot at 1.6 m, field of view 90 degrees."""
    return [Camera((x, 1.6, z), step_deg * k, horizon_deg, 90.0) for k in range(round(360 / step_deg))]
