"""Fits a form to its box: varies the requested size until the bounds of the drawn parts are those of the box."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from ovman_engine.shapes.part import IDENTITY, Part
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.tessellation import mesh

Form = Callable[[Subject], Iterable[Part]]

_FREE = frozenset({"tube", "leaf"})
"""Kinds of parts that need not touch the sides of their size."""
_ALIGNED = 1 - 1e-9

TOLERANCE_M = 2e-4
ROUNDS = 9
UNDAMPED = 3
"""Number of rounds with the full correction; later ones use less, so that forms with coupled sides converge."""


def bounds(parts: Iterable[Part], drawn_only: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,) of `parts`, metres."""
    lows, highs = [], []
    for part in parts:
        if not part.drawn and drawn_only:
            continue
        if (
            part.kind not in _FREE
            and part.segments % 4 == 0
            and (part.rotation is IDENTITY or (np.abs(part.rotation).max(axis=0) > _ALIGNED).all())
        ):
            reach = np.abs(part.rotation) @ (part.size / 2)
            lows.append(part.centre - reach)
            highs.append(part.centre + reach)
        else:
            vertices = mesh(part)[0]
            lows.append(vertices.min(axis=0))
            highs.append(vertices.max(axis=0))
    return np.min(lows, axis=0), np.max(highs, axis=0)


def fitted(form: Form, subject: Subject) -> tuple[Part, ...]:
    """Parts of `form` centred on the origin, their bounds those of `subject`'s size. Undrawn parts may only be smaller."""
    size = np.array([subject.w, subject.h, subject.d])
    asked = size.copy()
    parts: tuple[Part, ...] = ()
    for number in range(ROUNDS):
        parts = tuple(form(subject.of_size(*asked)))
        low, high = bounds(parts)
        if np.abs(high - low - size).max() < TOLERANCE_M:
            break
        asked = np.clip(asked * (size / (high - low)) ** (1.0 if number < UNDAMPED else 0.6), 0.3 * size, 2.5 * size)
    low, high = bounds(parts)
    middle = (low + high) / 2
    shrink = min(1.0, float((size / (high - low)).min()))
    shrink = 1.0 if shrink > 1 - 1e-4 else shrink
    return tuple(_within(_shrunk(p.but(centre=p.centre - middle), shrink), size / 2) for p in parts)


def _within(part: Part, half: np.ndarray) -> Part:
    """Return the part, cut to the box if it stands in for others in collisions; drawn parts are inside already."""
    if part.drawn or part.points is not None or part.rotation is not IDENTITY:
        return part
    low, high = np.maximum(part.centre - part.size / 2, -half), np.minimum(part.centre + part.size / 2, half)
    if not (high > low).all() or np.allclose(high - low, part.size):
        return part
    return part.but(centre=(low + high) / 2, size=high - low)


def _shrunk(part: Part, share: float) -> Part:
    if share == 1.0:
        return part
    points = None if part.points is None else part.points * share
    ratio = part.ratio * share if part.kind == "tube" else part.ratio
    return part.but(centre=part.centre * share, size=part.size * share, points=points, ratio=ratio, bevel=part.bevel * share)
