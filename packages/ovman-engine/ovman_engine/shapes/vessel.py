"""Hollow turned forms: profiles of radius and height, and what is made from them."""

from __future__ import annotations

from typing import Any

from ovman_engine.shapes.part import Part, lathe
from ovman_engine.shapes.subject import Subject

Profile = list[tuple[float, float]]


def vessel(outside: Profile, wall: float, floor: float) -> Profile:
    """Return a hollow profile, [(radius, y)].

    It goes along `outside` from the foot up, then down inside at `wall` to a bottom at height `floor`.
    """
    inside = [(max(r - wall, 1e-3), max(y, floor)) for r, y in reversed(outside) if y > floor]
    foot = inside[-1][0] if inside else outside[-1][0] - wall
    return [(0.0, outside[0][1]), *outside, *inside, (0.9 * foot, floor), (0.0, floor)]


def scaled(profile: Profile, radius: float, height: float) -> Profile:
    """Return a profile in unit radius and height, scaled."""
    return [(r * radius, y * height) for r, y in profile]


def turned(s: Subject, profile: Profile, slot: str = "main", **fields: Any) -> Part:
    """Return a profile in unit radius and height, revolved to fill the whole of `s`."""
    return lathe(scaled(profile, s.x, s.h), slot=slot, stretch=(1.0, s.z / s.x), **fields)
