"""The lights of a scene: ceiling lamps, windows, and lamps that are switched on.

Intensities are in arbitrary units. `Rig.exposure` scales them so that the middle of every room is equally bright.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from ovman_engine.picture.sunshine import Sun

SAMPLES = 8
"""Points of each light from which shadows fall."""
LAMPS = frozenset({"DeskLamp", "FloorLamp"})
MAX_WINDOWS, MAX_LAMPS = 2, 2
BELOW_CEILING_M = 0.12
MAX_LIGHT_M = 0.28
"""Largest half extent of a light for its shadows. The few samples resolve no wider penumbra."""
BELOW_LIGHT_M = 1.0
DARK = 1e-5
"""If the middle of the scene gets less than this share of the light one metre below the lights, brightness is measured there
instead: one object far outside the rooms of a house puts the middle of the scene outside as well."""
MIDDLE_BRIGHTNESS = 1.1
"""Linear light of a white card in the middle of the room that faces up."""
BOUNCE = (0.30, 0.32, 0.54)
"""Ambient light on surfaces that face up, sideways and down, as fractions of the direct light in the middle. A ceiling is lit by
the floor alone."""


@dataclass(frozen=True)
class Light:
    """A soft light."""

    position: np.ndarray
    """(3,) metres"""
    colour: np.ndarray
    """(3,) linear RGB intensity"""
    axis: np.ndarray
    """(3,) unit vector of the emission, which falls off as the cosine; zero for a light in all directions"""
    area: float
    """Area in square metres: softens the light on near surfaces"""
    spread: np.ndarray | None = None
    """(3,) half extents for its shadows; None for a light without shadows (windows)"""
    clearance: float = 0.0
    """Objects nearer than this to its position cast no shadow (its own shade), metres"""


@dataclass(frozen=True)
class Rig:
    """All light of a scene as arrays: L lights, S shadow samples."""

    lights: np.ndarray
    """(L, 11) float32: position, colour, axis, softening radius squared, 1 for a light with an axis"""
    shadowed: int
    """Number of lights with shadows, which come first"""
    samples: np.ndarray
    """(S, 6) float32: point on a light, clearance, number of the light, one over the light's number of samples"""
    ambient: np.ndarray
    """(3, 3) float32: ambient light from above, from the sides and from below"""
    exposure: float
    sun: Sun | None = None

    def key(self) -> bytes:
        """Bytes that are equal for equal light."""
        sun = b"" if self.sun is None else self.sun.way.tobytes() + self.sun.colour.tobytes() + self.sun.panes.tobytes()
        return self.lights.tobytes() + self.samples.tobytes() + self.ambient.tobytes() + np.float64(self.exposure).tobytes() + sun


def _hash(text: str) -> float:
    """Return a number in [0, 1) that is a function of the text."""
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "little") / 2**32


def _on(obj) -> bool:
    return bool(obj.record.get("isToggled", True)) if obj.record.get("toggleable", False) else True


def of_plan(room, low: np.ndarray, high: np.ndarray, boxes) -> tuple[Light, ...]:
    """Lights of a room.Room that spans low..high (3,) metres. `boxes`: objectId -> oriented box of every drawn object."""
    plan, hung = room.plan, room.lamps()
    warm = 0.55 + 0.45 * _hash(plan.name + "light")
    bulb = np.array([1.0, 0.93 - 0.05 * warm, 0.83 - 0.14 * warm])
    sky = np.array([0.86, 0.95, 1.0])
    down = np.array([0.0, -1.0, 0.0])
    lights = []
    for at in hung:
        centre = at - [0.0, BELOW_CEILING_M, 0.0]
        power = 6.0 / np.sqrt(len(hung) if plan.house is None else 1)
        lights.append(Light(centre, bulb * power, down, 1.2, np.array([MAX_LIGHT_M, 0.0, MAX_LIGHT_M]), 0.05))
    lamps = sorted((o for o in plan.objects if o.type in LAMPS and o.object_id in boxes and _on(o)), key=lambda o: o.object_id)
    for obj in lamps[:MAX_LAMPS]:
        box = boxes[obj.object_id]
        half = float(np.abs(box.rotation[1]) @ box.half)
        centre = box.centre + [0.0, 0.62 * half, 0.0]
        lights.append(Light(centre, np.array([1.0, 0.8, 0.52]) * 0.45, np.zeros(3), 0.25, np.full(3, 0.05), 0.45 * half + 0.12))
    windows = sorted(
        (o for o in plan.objects if o.type == "Window" and o.object_id in boxes), key=lambda o: -np.prod(np.sort(o.box.half)[1:])
    )
    for obj in windows[:MAX_WINDOWS]:
        reach = np.abs(obj.box.rotation) @ obj.box.half
        thin = 0 if reach[0] < reach[2] else 2
        inward = np.zeros(3)
        inward[thin] = np.sign((low + high)[thin] / 2 - obj.box.centre[thin]) or 1.0
        area = 4 * np.prod(np.delete(reach, thin))
        centre = obj.box.centre + inward * (reach[thin] + 0.1)
        lights.append(Light(centre, sky * 1.5 * np.sqrt(max(area, 0.3)), inward, area))
    return tuple(lights)


def irradiance(lights: np.ndarray, points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Unshadowed light (N, 3) on points (N, 3) of surfaces that face `normal` (3,)."""
    total = np.zeros((len(points), 3))
    for light in lights:
        away = light[:3] - points
        square = (away**2).sum(axis=1) + light[9]
        away = away / np.sqrt(square)[:, None]
        shine = np.where(np.any(light[6:9] != 0), np.maximum(-(away @ light[6:9]), 0), 1.0)
        total += (np.maximum(away @ normal, 0) * shine / square)[:, None] * light[3:6]
    return total


def rig(lights: tuple[Light, ...], low: np.ndarray, high: np.ndarray) -> Rig:
    """Return the lights as arrays, those with shadows first, with a fixed pattern of shadow samples on each.

    Also the exposure of a room low..high (3,).
    """
    table = np.array(
        [[*light.position, *light.colour, *light.axis, light.area / np.pi, float(np.any(light.axis))] for light in lights],
        dtype=np.float32,
    ).reshape(-1, 11)
    grid = np.stack(np.meshgrid(np.linspace(0.2, 0.8, 4), [0.3], np.linspace(0.2, 0.8, 4), indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + grid * (high - low)
    upward = np.array([0.0, 1.0, 0.0])
    below = table[:, :3] - BELOW_LIGHT_M * upward
    if irradiance(table, points, upward).mean() < DARK * irradiance(table, below, upward).mean():
        points = below
    shadowed = [light for light in lights if light.spread is not None]
    # the additive recurrence of the plastic number spreads any number of points evenly
    steps = np.arange(1, SAMPLES + 1)[:, None] * np.array([0.8191725134, 0.6710436067, 0.5497004779])
    offsets = ((0.5 + steps) % 1.0) * 2 - 1
    samples = np.array(
        [
            [*(light.position + offset * light.spread), light.clearance, k, 1.0 / SAMPLES]
            for k, light in enumerate(shadowed)
            for offset in offsets
        ],
        dtype=np.float32,
    ).reshape(-1, 6)
    direct = irradiance(table, points, upward).mean(axis=0)
    fill = direct.mean()
    tint = direct / max(fill, 1e-9)
    ambient = fill * np.array([BOUNCE[0] * tint, BOUNCE[1] * (0.5 + 0.5 * tint), BOUNCE[2] * tint * [1.0, 0.96, 0.9]])
    exposure = MIDDLE_BRIGHTNESS / float(fill + ambient[0].mean())
    return Rig(table, len(shadowed), samples, ambient.astype(np.float32), exposure)
