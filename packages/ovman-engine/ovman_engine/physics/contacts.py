"""Contacts in MuJoCo's compiled scene: overlaps of a body, and impacts between bodies."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

SIDEWAYS_M_S, UPWARD_M_S, DOWNWARD_M_S = 0.05, 0.05, 0.5
"""An impact wakes a body that it would move faster than this. Downwards, the support of the body resists."""


@dataclass(frozen=True)
class Overlap:
    """`other` reaches `depth` metres into a body. `up` is the vertical component of the direction that separates them soonest."""

    other: str
    depth: float
    up: float


def overlaps(model: mujoco.MjModel, data: mujoco.MjData, names: list[str], body: int) -> list[Overlap]:
    """Overlaps of body number `body`, one for each other body, deepest first. `names` are MuJoCo's bodies by number."""
    deepest: dict[str, Overlap] = {}
    for contact, other, out in _of(model, data, body):
        found = Overlap(names[other], -float(data.contact.dist[contact]), float(out[2]))
        if found.other not in deepest or found.depth > deepest[found.other].depth:
            deepest[found.other] = found
    return sorted(deepest.values(), key=lambda o: (-o.depth, o.other))


def struck(
    model: mujoco.MjModel, data: mujoco.MjData, qpos: np.ndarray, qvel: np.ndarray, body: int, light: Collection[int]
) -> set[int]:
    """Numbers of the fixed bodies `light` that the impact of the free body `body` would move.

    `qpos` and `qvel` are the state before the contacts: a body that has hit something fixed has lost its speed. The impact is
    taken to be inelastic, along the contact's normal.
    """
    joint = model.body_jntadr[body]
    q, v = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
    frame = np.empty(9)
    mujoco.mju_quat2Mat(frame, qpos[q + 3 : q + 7])
    spin = frame.reshape(3, 3) @ qvel[v + 3 : v + 6]
    found = set()
    for contact, other, out in _of(model, data, body):
        if other not in light:
            continue
        velocity = qvel[v : v + 3] + np.cross(spin, data.contact.pos[contact] - qpos[q : q + 3])
        share = model.body_mass[body] / (model.body_mass[body] + model.body_mass[other])
        given = -out * max(0.0, -float(velocity @ out)) * share
        if np.hypot(given[0], given[1]) > SIDEWAYS_M_S or given[2] > UPWARD_M_S or given[2] < -DOWNWARD_M_S:
            found.add(other)
    return found


def touching_pairs(model: mujoco.MjModel, data: mujoco.MjData) -> set[tuple[int, int]]:
    """Pairs of numbers of touching bodies, the smaller number first."""
    return {tuple(pair) for pair in np.sort(model.geom_bodyid[data.contact.geom], axis=1).tolist()}


def _of(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Iterator[tuple[int, int, np.ndarray]]:
    """Yield (contact, other body, unit normal out of it) of a body's contacts, in MuJoCo's frame."""
    bodies = model.geom_bodyid[data.contact.geom]
    frames = data.contact.frame
    for k in np.flatnonzero((bodies == body).any(axis=1)).tolist():
        first, second = bodies[k].tolist()
        yield k, first if second == body else second, frames[k, :3] if second == body else -frames[k, :3]
