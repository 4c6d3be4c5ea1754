"""Which bodies are awake, and what happens to them: the bodies of a world on one side, MuJoCo's compiled scene on the other."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import cached_property

import numpy as np

from ovman.engine.body import Agent, Body, Pose
from ovman.engine.floorplan import Box
from ovman.engine.physics import TICK_S, Model, Solid
from ovman.engine.setting import Setting


def within(box: Box, pieces: Iterable[tuple]) -> list[Box]:
    """World-frame boxes around `pieces` of a body whose box is `box`."""
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
    """`pieces` of `inner`'s frame in `outer`'s."""
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


class Dynamics:
    """The awake bodies of a world. Compiles nothing before something is asked of it."""

    def __init__(self, setting: Setting, bodies: Mapping[str, Body], agent: Agent) -> None:
        self._setting, self._bodies, self._agent = setting, bodies, agent
        self.awake: set[str] = set()
        self._fresh: set[str] = set()
        self._pardons: dict[str, set[str]] = {}
        self._model: Model | None = None
        self._embodiment = agent.embodiment
        self._written: dict[str, Pose] = {}
        self._owed_s = 0.0

    def parts(self, object_id: str) -> list[Body]:
        """The fixed parts of a body."""
        return [b for b in self._bodies.values() if b.carrier == object_id]

    def surfaces(self, body: Body) -> list[Box]:
        """Boxes around the pieces of a body, and of its parts, where they are now."""
        pieces = self._pieces.get(body.object_id)
        return within(body.box, self._setting.pieces[body.obj.object_id] if pieces is None else pieces)

    @cached_property
    def _pieces(self) -> dict[str, tuple]:
        made = self._setting.pieces
        out = {}
        for name, body in self._bodies.items():
            if body.carrier is None and body.obj.type != "Floor":
                own = list(made[body.obj.object_id])
                for part in self.parts(name):
                    if part.removed or (body.present and not part.active):
                        continue
                    own += transferred(made[part.obj.object_id], part.obj.box, body.obj.box)
                out[name] = tuple(own)
        return out

    def bodies_changed(self) -> None:
        """Call when bodies got other names or other parts, or when new ones came."""
        self.__dict__.pop("_pieces", None)
        self._model = None

    def speed(self, name: str) -> float:
        """v**2 + w**2 of a body, m/s and rad/s; 0 if it sleeps."""
        velocity = self._bodies[name].velocity if name in self.awake else np.zeros(6)
        return float(velocity @ velocity)

    def wake(self, names: Iterable[str]) -> None:
        """Let bodies fall. What they overlap now does not touch them until they sleep."""
        for name in names:
            self.awake.add(name)
            self._fresh.add(name)
            self._pardons.pop(name, None)

    def make_room(self) -> None:
        """Call when a body has come: what is awake does not touch what it overlaps now."""
        self._fresh |= self.awake

    def still(self, name: str) -> None:
        """Make a body fixed again."""
        self.awake.discard(name)
        self._fresh.discard(name)
        self._pardons.pop(name, None)
        self._bodies[name].velocity = np.zeros(6)

    def probe(self, name: str, also: Collection[str] = ()) -> Model:
        """The scene as it is now with `name` (and what is awake, and `also`) free, to ask questions of."""
        return self._current(frozenset({name, *also, *self.awake}))

    def forget(self, name: str) -> None:
        """The probed scene has `name` elsewhere than its body is."""
        self._written.pop(name, None)

    def advance(self, seconds: float, until_asleep: str | None = None) -> bool:
        """Run for `seconds`, or until nothing (or the body `until_asleep`) is awake. Whether any body moved."""
        if not self.awake:
            self._owed_s = 0.0
            return False
        model = self._current(frozenset(self.awake))
        self._owed_s += seconds
        while self._owed_s > TICK_S - 1e-9:
            self._owed_s -= TICK_S
            model.tick()
            if model.asleep or (until_asleep is not None and model.sleeps(until_asleep)):
                self._owed_s = 0.0
        for name in model.free:
            body = self._bodies[name]
            box, velocity = model.box(name, body.obj.box.half)
            body.pose, body.velocity = body.pose_for(box), velocity
            self._written[name] = body.pose
        if model.asleep:
            for name in list(self.awake):
                self.still(name)
        return True

    def _current(self, free: frozenset[str]) -> Model:
        embodiment = self._agent.embodiment
        if self._model is None or set(self._model.free) != free or self._embodiment != embodiment:
            solids = [
                Solid(name, pieces, self._bodies[name].obj.mass, self._bodies[name].dynamic)
                for name, pieces in self._pieces.items()
            ]
            boxes = {name: self._bodies[name].box for name in self._pieces}
            walls = {w.name: w.box for w in self._setting.room.solids}
            capsule = (embodiment.radius_m, embodiment.height_m)
            self._model = Model(solids, boxes, free, walls, self._setting.plan.floor_y, capsule)
            self._embodiment = embodiment
            self._written = {}
        model = self._model
        for name in self._pieces:
            body = self._bodies[name]
            model.set_present(name, body.present)
            if self._written.get(name) is not body.pose:
                model.set_box(name, body.box, body.velocity)
                self._written[name] = body.pose
        model.set_agent(self._agent.position + [0.0, embodiment.centre_m, 0.0])
        model.pardon({})
        model.forward()
        for name in sorted(self._fresh & free):
            self._pardons[name] = model.overlapped(name)
            model.rouse(name)
            self._fresh.discard(name)
        if self._pardons:
            model.pardon(self._pardons)
            model.forward()
        return model
