"""Sunlight through windows: patches on floors and furniture, with the shadows of glazing bars and objects.

All numbers are float32, in a fixed order and without fast-math. The kernels call nothing from other files: numba's cache watches
the file of the compiled function only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

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
LIFT_M = np.float32(0.004)


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


@njit(cache=True, error_model="numpy")
def through(grid, way, panes, starts, ways, reach, which):
    """Write the rays from points of the coarse `grid` (N, GRID) to the panes, and return their number.

    A ray has its start, its way (N, 3), its reach (N,) in lengths of the way, and the number of its point, which (N,).
    """
    count = 0
    for q in range(len(grid)):
        if grid[q, 3] * way[0] + grid[q, 4] * way[1] + grid[q, 5] * way[2] <= np.float32(0.02):
            continue
        for k in range(len(panes)):
            axis = np.int64(panes[k, 0])
            far = (panes[k, 1] - grid[q, axis]) / way[axis]
            if far < np.float32(0.02):
                continue
            across, y = grid[q, 2 - axis] + far * way[2 - axis], grid[q, 1] + far * way[1]
            if across > panes[k, 2] and across < panes[k, 3] and y > panes[k, 4] and y < panes[k, 5]:
                for a in range(3):
                    starts[count, a] = grid[q, a] + LIFT_M * grid[q, 3 + a]
                    ways[count, a] = way[a] * far
                reach[count] = np.float32(1)
                which[count] = q
                count += 1
                break
    return count


@njit(cache=True, error_model="numpy")
def add(blocked, which, way, colour, wide, high, grid):
    """Add sunlight to the coarse grid (high x wide points) at the points `which` (M,) that are not `blocked` (M,).

    It is spread over neighbours on the same surface with weights 1 2 1.
    """
    lit = np.zeros(wide * high, np.float32)
    for i in range(len(which)):
        if blocked[i]:
            continue
        q = which[i]
        x, y = q % wide, q // wide
        for dy in range(max(-1, -y), min(2, high - y)):
            for dx in range(max(-1, -x), min(2, wide - x)):
                p = q + dy * wide + dx
                if grid[p, 3] * grid[q, 3] + grid[p, 4] * grid[q, 4] + grid[p, 5] * grid[q, 5] > np.float32(0.9):
                    lit[p] += np.float32((2 - abs(dx)) * (2 - abs(dy))) * np.float32(1 / 16)
    power = colour[0] + colour[1] + colour[2]
    for q in range(wide * high):
        if lit[q] > 0:
            bright = lit[q] * (grid[q, 3] * way[0] + grid[q, 4] * way[1] + grid[q, 5] * way[2])
            for k in range(3):
                grid[q, 6 + k] += colour[k] * bright
                grid[q, 9 + k] += way[k] * power * lit[q]
