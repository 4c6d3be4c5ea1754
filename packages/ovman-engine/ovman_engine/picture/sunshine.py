"""Sunlight through windows: patches on floors and furniture, with the shadows of glazing bars and objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ovman_engine.plan.floorplan import FloorPlan
from ovman_engine.shapes import surroundings
from ovman_engine.shapes.style import Style

SUNNY = 0.8
"""Fraction of the scenes with sunlight."""
HEIGHT_DEG, ASIDE_DEG = (26.0, 48.0), 38.0
"""Range of the sun's height, and its largest angle to the axis of the largest window."""
BRIGHTNESS = 2.4
"""Light of the sun on a surface that faces it, relative to that of a white card in the middle of the room."""
CASING_M = 0.03


@dataclass(frozen=True)
class Sun:
    """The sun, and the panes through which it shines."""

    way: np.ndarray
    """(3,) float32 unit vector towards the sun"""
    colour: np.ndarray
    """(3,) float32 linear RGB intensity"""
    panes: np.ndarray
    """(W, 6) float32: axis (0 or 2), coordinate of the plane, low and high along the other axis, bottom, top; metres"""


def of_plan(plan: FloorPlan, low: np.ndarray, high: np.ndarray, present, exposure: float) -> Sun | None:
    """Return the sun of a floor plan whose room spans low..high (3,) metres, drawn from the plan's name.

    None without sunlight.

    `present`: objectIds of present objects; exposure as in `lights.Rig`.
    """
    style = Style(f"{plan.name}|sun")
    windows = sorted(
        (o for o in plan.objects if o.type == "Window" and o.object_id in present),
        key=lambda o: -np.prod(np.sort(o.box.half)[1:]),
    )
    if not windows or not style.chance("sunny", SUNNY):
        return None
    inwards = [w.box.rotation @ surroundings.direction(surroundings.front(w, plan)) for w in windows]
    aside, height = np.radians(style.uniform("aside", -ASIDE_DEG, ASIDE_DEG)), np.radians(style.uniform("height", *HEIGHT_DEG))
    x, z = -inwards[0][0], -inwards[0][2]
    way = np.array([x * np.cos(aside) + z * np.sin(aside), np.tan(height), z * np.cos(aside) - x * np.sin(aside)])
    way /= np.linalg.norm(way)
    panes = []
    for window, inward in zip(windows, inwards, strict=True):
        axis = int(np.argmax(np.abs(inward)))
        first, last = window.box.bounds()
        half = (last[axis] - first[axis]) / 2
        if -inward @ way < 0.1 or axis == 1:
            continue
        plane = window.box.centre[axis] + inward[axis] * (0.3 * min(half, 0.05) - half + 0.004)
        along = 2 - axis
        panes.append((axis, plane, first[along] + CASING_M, last[along] - CASING_M, first[1] + CASING_M, last[1] - CASING_M))
    warm = np.array([1.0, 0.93 - 0.08 * style.fraction("warm"), 0.80 - 0.16 * style.fraction("warm")])
    colour = warm * BRIGHTNESS / exposure
    return Sun(way.astype(np.float32), colour.astype(np.float32), np.array(panes, dtype=np.float32).reshape(-1, 6))
