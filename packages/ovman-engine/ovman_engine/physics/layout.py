"""Compiles a scene for MuJoCo, and caches compiled scenes: compiling takes 20 ms, a copy 1 ms."""

from __future__ import annotations

import copy
import hashlib
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from ovman_engine.bodies.forms import AGENT, BOUNDS
from ovman_engine.physics.geoms import FRICTION, SWAP, Piece, add, quaternion
from ovman_engine.plan.floorplan import Box

STEP_S = 0.005
AGENT_GROUP = 3
"""Group of geoms on which nothing is placed: the agent, and the walls around the scene."""
KEPT = 64
"""Number of cached scenes, about a megabyte each."""

KEPT_PIECES = 2048
"""Number of bodies whose pieces' digests are cached."""

_kept: OrderedDict[bytes, mujoco.MjModel] = OrderedDict()
_digests: OrderedDict[int, tuple[tuple[Piece, ...], bytes]] = OrderedDict()
"""By the identity of the pieces, which are kept with their digest"""


@dataclass(frozen=True)
class Solid:
    """A body as MuJoCo needs it."""

    name: str
    pieces: tuple[Piece, ...]
    mass: float
    moving: bool
    """Whether its pose can change; other bodies belong to the static scene"""


@dataclass(frozen=True)
class Layout:
    """A scene to compile. Lengths in metres, world frame as in `floorplan`."""

    solids: Sequence[Solid]
    boxes: Mapping[str, Box]
    """Poses of all `solids`"""
    free: frozenset[str]
    """Names of free bodies"""
    walls: Mapping[str, Box]
    floor_y: float
    capsule: tuple[float, float]
    """Radius and height of the agent"""
    strangers: frozenset[tuple[str, str]] = frozenset()
    """Pairs of bodies that do not collide; one of them is free"""
    bounds: tuple[np.ndarray, np.ndarray] | None = None
    """Lower and upper corner (3,) of invisible walls and a ceiling"""

    def model(self) -> mujoco.MjModel:
        """Return the compiled scene. The caller may change it: a cached scene is copied."""
        key = self._digest()
        found = _kept[key] = _kept.pop(key, None) or self._compiled()
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
        return copy.copy(found)

    def _digest(self) -> bytes:
        found = hashlib.blake2b(digest_size=16)
        boxes = [self.boxes[solid.name] for solid in self.solids]
        solids = [(solid.name, _digest_of(solid.pieces), solid.mass, solid.moving) for solid in self.solids]
        others = (sorted(self.free), self.walls, self.floor_y, self.capsule, sorted(self.strangers), self.bounds)
        for part in _content((solids, boxes, *others)):
            found.update(part)
        return found.digest()

    def _compiled(self) -> mujoco.MjModel:
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP_S
        spec.option.gravity = [0.0, 0.0, -9.81]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.iterations = 50
        spec.worldbody.add_geom(
            name="Floor",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0, 0, 1],
            pos=[0, 0, self.floor_y],
            contype=1,
            conaffinity=0,
            friction=FRICTION,
            condim=6,
        )
        for solid in self.solids:
            box = self.boxes[solid.name]
            body = spec.worldbody.add_body(name=solid.name, pos=box.centre[SWAP], quat=quaternion(box.rotation))
            if solid.name in self.free:
                body.add_freejoint()
            else:
                body.mocap = solid.moving
            for k, piece in enumerate(solid.pieces):
                add(spec, body, f"{solid.name}#{k}", piece, contype=1, conaffinity=int(solid.name in self.free))
        for name, box in self.walls.items():
            body = spec.worldbody.add_body(name=name, pos=box.centre[SWAP], quat=quaternion(box.rotation))
            add(spec, body, f"{name}#", ("box", np.zeros(3), box.half, np.eye(3)), contype=1, conaffinity=0)
        radius, height = self.capsule
        agent = spec.worldbody.add_body(name=AGENT, mocap=True, pos=[0, 0, -100])
        agent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[radius, height / 2 - radius, 0],
            contype=1,
            conaffinity=0,
            group=AGENT_GROUP,
            condim=3,
        )
        if self.bounds is not None:
            _enclose(spec, *self.bounds)
        for pair in sorted(self.strangers):
            spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
        return spec.compile()


def _digest_of(pieces: tuple[Piece, ...]) -> bytes:
    """Digest of the pieces of a body.

    They never change, and bodies of one floor plan share them: most scenes are digested more often than compiled.
    """
    kept = _digests.get(id(pieces))
    if kept is None:
        found = hashlib.blake2b(digest_size=16)
        for part in _content(pieces):
            found.update(part)
        kept = _digests[id(pieces)] = pieces, found.digest()
        while len(_digests) > KEPT_PIECES:
            _digests.popitem(last=False)
    return kept[1]


def _content(value: Any) -> Iterator[bytes]:
    """Bytes that are equal only for equal values."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield value.tobytes()
    elif isinstance(value, Box):
        yield from _content((value.centre, value.half, value.rotation))
    elif isinstance(value, Mapping):
        yield from _content(list(value.items()))
    elif isinstance(value, list | tuple):
        yield f"{len(value)}[".encode()
        for one in value:
            yield from _content(one)
    else:
        yield f"{value!r};".encode()


def _enclose(spec: mujoco.MjSpec, low: np.ndarray, high: np.ndarray) -> None:
    """Add invisible planes around the bounds, except below."""
    around = spec.worldbody.add_body(name=BOUNDS)
    low, high = low[SWAP], high[SWAP]
    for axis, corner, inwards in ((0, low, 1), (0, high, -1), (1, low, 1), (1, high, -1), (2, high, -1)):
        at, normal = np.zeros(3), np.zeros(3)
        at[axis], normal[axis] = corner[axis], inwards
        turn = np.empty(4)
        mujoco.mju_quatZ2Vec(turn, normal)
        around.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0, 0, 1],
            pos=at,
            quat=turn,
            contype=1,
            conaffinity=0,
            group=AGENT_GROUP,
            condim=3,
        )
