"""Convex pieces of bodies: boxes around them, their transfer to another body's frame, and feet for bodies without any.

A piece is one of `shapes.collision`, in the frame of the oriented box of its body.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ovman_engine.plan.floorplan import Box

AGENT, BOUNDS = "Agent", "Bounds"
"""Names of the agent's capsule and of the boundary that nothing passes."""
FOOT_M = 0.002
"""A body gets feet if its pieces end farther above the bottom of its box than this."""
FOOT_HALF_M = 0.01
INSET = 0.85
"""Position of feet, as a fraction of the half extents of what they carry."""


def within(box: Box, pieces: Iterable[tuple]) -> list[Box]:
    """World-frame boxes around the `pieces` of a body whose box is `box`."""
    out = []
    for piece in pieces:
        centre, half, rotation = extent(piece)
        out.append(Box(box.centre + box.rotation @ centre, half, box.rotation @ rotation))
    return out


def extent(piece: tuple) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre, half extents and rotation of the box around a piece, in the piece's frame."""
    kind = piece[0]
    if kind == "hull":
        low, high = piece[1].min(axis=0), piece[1].max(axis=0)
        return (low + high) / 2, (high - low) / 2, np.eye(3)
    if kind == "sphere":
        return piece[1], np.full(3, piece[2]), np.eye(3)
    if kind in ("cylinder", "capsule"):
        return piece[1], np.array([piece[2], piece[3] + (piece[2] if kind == "capsule" else 0.0), piece[2]]), piece[4]
    return piece[1], piece[2], piece[3]


def transferred(pieces: Iterable[tuple], inner: Box, outer: Box) -> tuple:
    """`pieces` in the frame of `inner`, transferred to the frame of `outer`."""
    turn, shift = outer.rotation.T @ inner.rotation, outer.rotation.T @ (inner.centre - outer.centre)
    out = []
    for kind, first, *rest in pieces:
        if kind == "hull":
            out.append((kind, first @ turn.T + shift))
        elif kind == "sphere":
            out.append((kind, turn @ first + shift, *rest))
        else:
            out.append((kind, turn @ first + shift, *rest[:-1], turn @ rest[-1]))
    return tuple(out)


def feet(pieces: Iterable[tuple], half: np.ndarray) -> tuple:
    """Return a post between the lowest pieces and the bottom of the box of half extents `half`; none if the pieces reach it.

    It is for legs that are drawn thinner than they collide (a sofa's).
    """
    bounds = []
    for piece in pieces:
        centre, reach, rotation = extent(piece)
        spread = np.abs(rotation) @ reach
        bounds.append((centre - spread, centre + spread))
    lowest = min((low[1] for low, _ in bounds), default=-half[1])
    if lowest + half[1] <= FOOT_M:
        return ()
    near = [(low, high) for low, high in bounds if low[1] < lowest + 2 * FOOT_HALF_M]
    low, high = np.min([b[0] for b in near], axis=0), np.max([b[1] for b in near], axis=0)
    centre, reach = (low + high) / 2, np.maximum((high - low) / 2 * INSET - FOOT_HALF_M, 0.0)
    tall = (lowest + half[1]) / 2
    size = np.array([FOOT_HALF_M, tall, FOOT_HALF_M])
    places = [[centre[0] + x * reach[0], tall - half[1], centre[2] + z * reach[2]] for x in (-1, 1) for z in (-1, 1)]
    return tuple(("box", np.array(place), size, np.eye(3)) for place in places)
