"""Which bodies are awake, and how they move: mediates between the bodies of a world and MuJoCo's compiled scene."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ovman_engine.bodies.body import Agent, Body, Pose
from ovman_engine.bodies.carrying import RESTS_M
from ovman_engine.bodies.forms import AGENT, BOUNDS, within
from ovman_engine.bodies.static_scene import StaticScene
from ovman_engine.physics.waking import OVERLAP_M, lift, supported
from ovman_engine.plan.floorplan import Box

if TYPE_CHECKING:
    from ovman_engine.physics.physics import Model

MARGIN_M = 0.3
"""Nothing moves farther than this beyond the recorded bounds."""
TIRED_S = 20.0
"""A body that has moved for this long is put to sleep: light bodies may tremble for ever."""
STAYED_M, STAYED_RAD = 0.002, 0.01
"""A body that has moved less than this since it woke has not moved."""

Load = Callable[[str], Collection[str]]
"""objectId of a body -> objectIds of what it carries."""


class Dynamics:
    """The awake bodies of a world. The scene is compiled only when it is needed."""

    def __init__(self, static: StaticScene, bodies: Mapping[str, Body], agent: Agent) -> None:
        """`bodies` and `agent` are the world's own and may change between calls."""
        self._static, self._bodies, self._agent = static, bodies, agent
        self.awake: set[str] = set()
        self._fresh: set[str] = set()
        self._strangers: set[tuple[str, str]] = set()
        self._held: set[str] = set()
        """Bodies without known support that stay at their recorded pose"""
        self._woken: dict[str, tuple[Pose, Pose]] = {}
        """Awake bodies: their poses when they woke, and after they were lifted out of their support"""
        self._awake_s: dict[str, float] = {}
        self._model: Model | None = None
        self._embodiment = agent.embodiment
        self._written: dict[str, Pose] = {}
        self._owed_s = 0.0
        self._agent_at: np.ndarray | None = None
        self._reached: dict[str, tuple[Pose, bool]] = {}

    def parts(self, object_id: str) -> list[Body]:
        """Return the fixed parts of a body."""
        return [b for b in self._bodies.values() if b.carrier == object_id]

    def surfaces(self, body: Body) -> list[Box]:
        """Boxes around the pieces of a body and of its parts, at their current poses."""
        pieces = self._pieces.get(body.object_id)
        return within(body.box, self._static.pieces[body.obj.object_id] if pieces is None else pieces)

    @cached_property
    def _pieces(self) -> dict[str, tuple]:
        out = {}
        for name, body in self._bodies.items():
            if body.carrier is None and body.obj.type != "Floor":
                there = [p.obj for p in self.parts(name) if not p.removed and (p.active or not body.present)]
                out[name] = self._static.pieces_with(body.obj, there)
        return out

    def bodies_changed(self) -> None:
        """To be called after bodies were renamed, added or removed, or got other parts."""
        self.__dict__.pop("_pieces", None)
        self._model = None
        self._held &= self._bodies.keys()
        known = {AGENT, BOUNDS, *self._bodies, *(w.name for w in self._static.room.solids)}
        self._strangers = {pair for pair in self._strangers if known.issuperset(pair)}

    def speed(self, name: str) -> float:
        """v**2 + w**2 of a body, m/s and rad/s; 0 if it is asleep."""
        velocity = self._bodies[name].velocity if name in self.awake else np.zeros(6)
        return float(velocity @ velocity)

    def wake(self, names: Iterable[str]) -> None:
        """Wakes bodies, so that they fall. A body does not collide with what it overlaps now until it sleeps again."""
        for name in names:
            if not self._bodies[name].present or not self._reaches(self._bodies[name].box.centre):
                continue
            self.awake.add(name)
            self._fresh.add(name)
            self._held.discard(name)
            self._woken.setdefault(name, (self._bodies[name].pose, self._bodies[name].pose))
            self._strangers = {pair for pair in self._strangers if name not in pair}

    def _reaches(self, point: np.ndarray) -> bool:
        """Whether bodies at a point (3,) are simulated: far outside, nothing would ever come to rest."""
        low, high = self._bounds
        return bool(((point >= low) & (point <= high)).all())

    @cached_property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        low, high = self._static.bounds
        low = np.array([low[0], self._static.plan.floor_y, low[2]])
        return low - [MARGIN_M, 0.0, MARGIN_M], high + MARGIN_M

    def make_room(self) -> None:
        """To be called after a body appeared: awake bodies do not collide with what they overlap now."""
        self._fresh |= self.awake

    def still(self, name: str) -> None:
        """Put a body to sleep."""
        self.awake.discard(name)
        self._fresh.discard(name)
        self._woken.pop(name, None)
        self._awake_s.pop(name, None)
        self._strangers = {pair for pair in self._strangers if not self.awake.isdisjoint(pair)}
        self._bodies[name].velocity = np.zeros(6)

    def probe(self, name: str, also: Collection[str] = ()) -> Model:
        """Return the compiled scene with `name`, `also` and all awake bodies free, for queries."""
        free = frozenset({name, *also, *self.awake})
        return self._synchronised(free, {pair for pair in self._strangers if name not in pair})

    def forget(self, name: str) -> None:
        """To be called after a query that moved `name` in the compiled scene."""
        self._written.pop(name, None)

    def advance(self, seconds: float, load: Load, until_asleep: str | None = None) -> set[str]:
        """Run for `seconds`, or until all bodies (or the body `until_asleep`) sleep.

        Returns the objectIds of bodies that may have moved.

        A body that is hit wakes, and its load with it.
        """
        from ovman_engine.physics.physics import (
            TICK_S,  # imported here: most scenes are only looked at
        )

        moved = set(self.awake)
        self._owed_s = self._owed_s + seconds if self.awake else 0.0
        while self.awake and self._owed_s > TICK_S - 1e-9:
            model = self._current()
            if not self.awake:
                break
            model.tick()
            others = self._pieces.keys() - self.awake - self._held
            struck = model.struck([n for n, b in self._bodies.items() if n in others and self._can_wake(b)])
            if struck:
                model.undo()
                self._read(model)
                woken = struck.union(*(load(name) for name in sorted(struck))) - self.awake
                self.wake(sorted(woken))
                moved |= woken
                continue
            self._owed_s -= TICK_S
            model.watch()
            for name in model.free:
                self._awake_s[name] = self._awake_s.get(name, 0.0) + TICK_S
            resting = {name for name in model.free if model.sleeps(name) or self._awake_s[name] > TIRED_S}
            if resting:
                self._read(model)
                for heap in model.heaps():
                    if heap <= resting:
                        for name in sorted(heap):
                            self._fall_asleep(name)
            if until_asleep is not None and until_asleep not in self.awake:
                self._owed_s = 0.0
        if self.awake and (model := self._current()).free:
            self._read(model)
        else:
            self._owed_s = 0.0
        return moved

    def _can_wake(self, body: Body) -> bool:
        """Whether an impact can wake a body that is neither awake nor known to be held: those are not hit twice."""
        if not body.dynamic or not body.present or body.kinematic:
            return False
        pose, there = self._reached.get(body.object_id, (None, False))
        if pose is not body.pose:  # most bodies stay where they are while others fall
            there = self._reaches(body.box.centre)
            self._reached[body.object_id] = body.pose, there
        return there

    def _fall_asleep(self, name: str) -> None:
        """Put a body to sleep where it is, or at its former pose if it has only settled there again."""
        body = self._bodies[name]
        before, lifted = self._woken[name]
        turned = np.trace(lifted.rotation.T @ body.pose.rotation)
        if np.linalg.norm(body.pose.position - lifted.position) < STAYED_M and turned > 1 + 2 * np.cos(STAYED_RAD):
            body.pose = before
        self.still(name)

    def _read(self, model: Model) -> None:
        """Copy the poses of the compiled scene to the bodies."""
        for name in model.free:
            if name in self.awake:
                body = self._bodies[name]
                box, body.velocity = model.box(name, body.obj.box.half)
                body.pose = self._written[name] = body.pose_for(box)

    def _current(self) -> Model:
        """Return the compiled scene with the awake bodies free.

        A body that has just woken is lifted out of its support and does not collide with what it still overlaps. It stays where
        it is if its recorded support is unknown, or if it is sunk in a body and nothing else supports it: shapes are not exact,
        and it would fall through.
        """
        model = self._synchronised(frozenset(self.awake), self._strangers)
        trodden = self._trodden(model)
        if not self._fresh and not trodden:
            return model
        for name in sorted(self._fresh):
            body = self._bodies[name]
            lifted, strange = lift(model, name, body, self.awake)
            model.rouse(name)
            self._strangers |= {(min(name, other), max(name, other)) for other in strange}
            sunk = (strange & self._bodies.keys()) - self.awake
            if (sunk or (lifted is body.pose and self._is_kept(body))) and not supported(model, name, body, lifted, strange):
                self._held.add(name)
                self.still(name)
            elif lifted is not body.pose:
                self._woken[name] = (self._woken[name][0], lifted)
                body.pose = self._written[name] = lifted
        self._fresh.clear()
        self._strangers |= trodden
        return self._synchronised(frozenset(self.awake), self._strangers)

    def _trodden(self, model: Model) -> set[tuple[str, str]]:
        """Pairs of the agent and the bodies that it has stepped into since the last call; they do not collide."""
        if self._agent_at is not None and np.array_equal(self._agent_at, self._agent.position):
            return set()
        self._agent_at = self._agent.position.copy()
        deep = {(o.other, name) for name in model.free for o in model.overlaps(name) if o.depth > OVERLAP_M}
        return {pair for pair in deep if pair[0] == AGENT and pair not in self._strangers}

    def _is_kept(self, body: Body) -> bool:
        """Whether a body, and its recorded support, are at their recorded poses."""
        if not body.stays:
            return False
        keepers = [self._bodies.get(name) for name in body.obj.parents if not name.startswith("Floor|")]
        if not keepers:
            return body.obj.box.bounds()[0][1] > self._static.plan.floor_y + RESTS_M
        return all(k is not None and k.present and k.stays for k in keepers)

    def _synchronised(self, free: frozenset[str], strangers: Collection[tuple[str, str]]) -> Model:
        """Return the compiled scene with all bodies at their current poses."""
        from ovman_engine.physics.layout import Layout, Solid
        from ovman_engine.physics.physics import Model

        embodiment = self._agent.embodiment
        model = self._model if self._embodiment == embodiment else None
        if model is None or set(model.free) != free or model.strangers != frozenset(strangers):
            solids = [
                Solid(name, pieces, self._bodies[name].obj.mass, self._bodies[name].dynamic)
                for name, pieces in self._pieces.items()
            ]
            boxes = {name: self._bodies[name].box for name in self._pieces}
            walls = {w.name: w.box for w in self._static.room.solids}
            capsule = (embodiment.radius_m, embodiment.height_m)
            floor_y = self._static.plan.floor_y
            model = self._model = Model(Layout(solids, boxes, free, walls, floor_y, capsule, frozenset(strangers), self._bounds))
            self._written, self._embodiment = {}, embodiment
        for name in self._pieces:
            body = self._bodies[name]
            model.set_present(name, body.present)
            if self._written.get(name) is not body.pose:
                model.set_box(name, body.box, body.velocity)
                self._written[name] = body.pose
        model.set_agent(self._agent.position + [0.0, embodiment.centre_m, 0.0])
        model.forward()
        return model
