"""A world: a floor plan and everything that has changed in it since Reset.

World frame as in `floorplan`. The effects of changes, and the messages of refusals, are those of AI2-THOR 5.0.0.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ovman_engine.bodies.arrangement import arranged, named
from ovman_engine.bodies.body import Agent, Body, Pose
from ovman_engine.bodies.carrying import load_of, move, resting
from ovman_engine.bodies.passage import Obstacles
from ovman_engine.bodies.static_scene import StaticScene
from ovman_engine.physics.dynamics import Dynamics
from ovman_engine.plan.floorplan import Box, FloorPlan
from ovman_engine.world.errors import Refused, Unsettled
from ovman_engine.world.locomotion import Locomotion

if TYPE_CHECKING:
    from ovman_engine.physics.physics import Model

DROP_M = 10.0
"""How far below a point a surface is searched."""
GAP_M = 0.005
"""Height of a placed object above its surface."""
CLEAR_M = 0.001
"""Deepest overlap that does not count as a collision."""
SETTLE_S = 1.0
"""Simulated time in which a placed object must come to rest."""


RESTLESS = 0.01
"""v**2 + w**2 (m/s and rad/s) above which a placed object has not come to rest."""


class World:
    """The state of one scene. `version` increases whenever a body moves, appears or disappears."""

    def __init__(self, plan: FloorPlan, seed: int = 0) -> None:
        """Make the untouched scene of `plan`."""
        self.plan, self.seed = plan, seed
        self._static = StaticScene.of(plan)
        self.room = self._static.room
        self.agent = Agent(plan.start.copy(), self._static.start_yaw_deg)
        self.bodies: dict[str, Body] = {o.object_id: Body.of(o) for o in plan.objects}
        self.version = 0
        for part, carrier in self._static.carriers.items():
            self.bodies[part].carrier = carrier
        self._loose: set[str] = set()
        """Disabled objects that have lost their support"""
        self._dynamics = Dynamics(self._static, self.bodies, self.agent)
        self._locomotion = Locomotion(self._static, self.bodies, self.agent)

    # Queries

    def box(self, object_id: str) -> Box:
        """Return current oriented box of an object. Raises KeyError for an unknown objectId."""
        return self.bodies[object_id].box

    @property
    def at_rest(self) -> bool:
        """Whether no body is falling, rolling or about to."""
        return not self._dynamics.awake

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner of the untouched scene, metres."""
        return self._static.bounds

    # The agent

    def blocker(self, start_xz: ArrayLike, end_xz: ArrayLike, ignore: Collection[str] = ()) -> str | None:
        """Name of the obstacle on the agent's straight way between two points (2,); see `Locomotion.blocker`."""
        return self._locomotion.blocker(self.version, start_xz, end_xz, ignore)

    def reachable(self, step_m: float = 0.25, yaw_deg: float = 0.0) -> list[tuple[float, float, float]]:
        """Positions (x, y, z) that moves of `step_m` reach; see `Locomotion.reachable`."""
        return self._locomotion.reachable(self.version, step_m, yaw_deg)

    def obstacles(self) -> tuple[Obstacles, list[str]]:
        """Possible obstacles of the agent and their names; see `Locomotion.obstacles`."""
        return self._locomotion.obstacles(self.version)

    # Changes

    def place(
        self,
        object_id: str,
        position: ArrayLike,
        rotation: np.ndarray | None = None,
        kinematic: bool = False,
        settle: bool = True,
    ) -> np.ndarray:
        """PlaceObjectAtPoint: puts an object on the first surface below `position` (3,), with `rotation` (3, 3) or its own.

        The object settles for up to a second, unless `kinematic` or not `settle`. Returns the final position (3,) of its pivot,
        metres. Refused without effect if it would overlap anything. Raises Unsettled, with the object where it has got to, if it
        has not come to rest or has left the scene.
        """
        body = self._movable(object_id)
        point = np.array(position, dtype=float)
        low, high = self.bounds()
        if not _inside(point, low, high):
            middle, extents = (low + high) / 2, (high - low) / 2
            bounds = f"Center: {_text(middle)}, Extents: {_text(extents)}"
            raise Refused(f"Position coordinate ({_text(point)}) is not within scene bounds ({bounds})")
        load = self._load(body)
        surface = self._dynamics.probe(object_id, load).below(point, DROP_M, but=object_id)
        pose = Pose(point, body.pose.rotation if rotation is None else rotation)
        lift = (point[1] if surface is None else surface[0]) + GAP_M - body.box_at(pose).bounds()[0][1]
        pose = Pose(point + [0.0, lift, 0.0], pose.rotation)
        hit = self._overlap(body, pose, load)
        if hit is not None:
            raise Refused(f"Spawn area not clear ({hit}) is in the way), can't place object at that point")
        self._put(body, pose, kinematic, load)
        if settle and object_id in self._dynamics.awake:
            self._advance(SETTLE_S, object_id)
            if self._dynamics.speed(object_id) > RESTLESS or not _inside(body.box.centre, low, high):
                raise Unsettled("object couldn't come to rest")
        return body.pose.position

    def teleport(
        self,
        object_id: str,
        position: ArrayLike,
        rotation: np.ndarray | None = None,
        force: bool = False,
        kinematic: bool = False,
    ) -> None:
        """TeleportObject: puts an object's pivot exactly at `position` (3,), with `rotation` (3, 3) or its own.

        Refused without effect if it would overlap anything, or if it is a part of furniture or the floor, unless `force`. A part
        that is put elsewhere belongs to its furniture no longer. The ground on which things stand stays where it is.
        """
        body = self._listed(object_id) if force else self._movable(object_id)
        pose = Pose(np.array(position, dtype=float), body.pose.rotation if rotation is None else rotation)
        load = [] if body.obj.type == "Floor" else self._load(body)
        if not force and (hit := self._overlap(body, pose, load)) is not None:
            raise Refused(f"{object_id} is colliding with {hit} after teleport.")
        if body.carrier is not None:
            if pose.near(body.pose):
                return
            body.carrier = None
            self._dynamics.bodies_changed()
        self._put(body, pose, kinematic, load)

    def set_poses(
        self, poses: Sequence[Mapping[str, Any]], stationary: bool = True, asleep: bool = False, skip_moveable: bool = False
    ) -> None:
        """SetObjectPoses: [{objectName, position (3,), rotation (3, 3)}, ...].

        All other movable objects leave the scene for good. An object that is listed again, at index i, is copied as name_copy_i.
        objectIds follow the positions. Overlaps are not checked. Bodies that are neither `stationary` nor `asleep` fall. With
        `skip_moveable`, only pickupable objects are arranged or leave. Refused, after the others are placed, if no object that
        can be arranged has a listed name.
        """
        self._collect()
        here = [b for b in self.bodies.values() if not b.removed and (b.obj.pickupable or not skip_moveable)]
        listed, copies, unknown = arranged(here, poses, lambda body: self._dynamics.parts(body.object_id))
        for body in listed:
            body.kinematic = stationary
        self._collect()
        self._rename([*self.bodies.values(), *copies])
        if not stationary and not asleep:
            self._dynamics.wake(b.object_id for b in listed)
        self.version += 1
        if unknown is not None:
            raise Refused(f"No Pickupable or Moveable object of name {unknown} found in scene.")

    def set_active(self, object_id: str, active: bool) -> None:
        """EnableObject and DisableObject: a disabled object keeps its pose. Refused, without a message, if the object is unknown.

        An enabled object falls if it was moved, or lost its support, while it was disabled.
        """
        body = self.bodies.get(object_id)
        if body is None or body.removed:
            raise Refused("")
        if body.active != active:
            self._come_or_go([body], active=active)

    def remove(self, *object_ids: str) -> None:
        """RemoveFromScene: removes objects until Reset, and all disabled objects with them.

        Refused without effect if an object is unknown.
        """
        found = [self.bodies.get(object_id) for object_id in object_ids]
        bodies = [b for b in found if b is not None and not b.removed]
        if len(bodies) < len(found):
            raise Refused(
                "NullReferenceException: Object reference not set to an instance of an object. trace:   at RemoveFromScene"
            )
        self._come_or_go(bodies, removed=True)
        self._collect()

    @contextmanager
    def trial(self, object_ids: Sequence[str]) -> Iterator[Model]:
        """Yield the compiled scene, in which a caller may move bodies and query overlaps. The world stays as it is."""
        try:
            yield self._dynamics.probe(object_ids[0], object_ids)
        finally:
            self._dynamics.bodies_changed()

    def rearrange(self, poses: Mapping[str, Pose], stationary: bool) -> None:
        """Put bodies at `poses`, by objectId, all at once and unchecked.

        What only they carried falls, unless it is among them.
        """
        loads = {name for object_id in poses for name in self._load(self.bodies[object_id])} - poses.keys()
        standing = [b for b in self.bodies.values() if b.present and b.object_id not in loads and b.object_id not in poses]
        carried = [self.bodies[name] for name in sorted(loads)]
        loads = loads.difference(*(resting(self._dynamics.surfaces(b), carried, self.plan.floor_y) for b in standing))
        for object_id, pose in poses.items():
            body = self.bodies[object_id]
            self._move(body, pose)
            body.kinematic = stationary
            self._dynamics.still(object_id)
        self._let_go(sorted(loads))
        if not stationary:
            self._let_go(sorted(poses))
        self.version += 1

    def duplicate(self, body: Body, number: int) -> Body:
        """Return a copy of `body` at the same pose, with AI2-THOR's names for random copies. Rearrange or discard it at once."""
        twin = Body.of(body.obj)
        twin.object_id, twin.name, twin.pose = f"{body.object_id}_copy_{number}", f"{body.name}_random_copy_{number}", body.pose
        while twin.object_id in self.bodies:
            twin.object_id, twin.name = f"{twin.object_id}_copy", f"{twin.name}_copy"
        self.bodies[twin.object_id] = twin
        self._dynamics.bodies_changed()
        return twin

    def discard(self, bodies: Iterable[Body]) -> None:
        """Remove duplicates that found no place."""
        for body in bodies:
            del self.bodies[body.object_id]
            self._dynamics.bodies_changed()

    def advance(self, seconds: float) -> None:
        """Run physics. Costs nothing while the world is at rest."""
        self._advance(seconds)

    # Implementation

    def _listed(self, object_id: str) -> Body:
        body = self.bodies.get(object_id)
        if body is None or body.removed:
            raise Refused(f"Cannot find object with id {object_id}.")
        return body

    def _movable(self, object_id: str) -> Body:
        body = self._listed(object_id)
        if body.carrier is not None or body.obj.type == "Floor":
            raise Refused(f"{object_id} cannot be moved: it is a part of {body.carrier or 'the room'}.")
        return body

    def _load(self, body: Body) -> list[str]:
        """Return the objectIds of what a body carries, directly and indirectly."""
        return load_of(body, self.bodies, self._dynamics.surfaces, self._dynamics.parts, self.plan.floor_y)

    def _overlap(self, body: Body, pose: Pose, load: Collection[str]) -> str | None:
        """Name of what `body` would overlap at `pose`.

        Its load is ignored, because it will fall; so is the floor, on which it stands.
        """
        model = self._dynamics.probe(body.object_id, load)
        model.set_box(body.object_id, body.box_at(pose))
        model.forward()
        touching = model.touching(body.object_id)
        self._dynamics.forget(body.object_id)
        return next((name for name, depth in touching if depth > CLEAR_M), None)

    def _put(self, body: Body, pose: Pose, kinematic: bool, load: Collection[str]) -> None:
        self._move(body, pose)
        body.kinematic = kinematic
        self._dynamics.still(body.object_id)
        self._let_go(load)
        if body.dynamic and not kinematic:
            self._let_go([body.object_id])
        self.version += 1

    def _let_go(self, names: Collection[str]) -> None:
        """Lets bodies fall: now, or as soon as they are enabled."""
        self._dynamics.wake(name for name in names if self.bodies[name].present)
        self._loose |= {name for name in names if not self.bodies[name].present}

    def _move(self, body: Body, pose: Pose) -> None:
        move(body, self._dynamics.parts(body.object_id), pose)

    def _come_or_go(self, bodies: Sequence[Body], **state: bool) -> None:
        loads = [self._load(body) for body in bodies]
        for body in bodies:
            for one in (body, *self._dynamics.parts(body.object_id)):
                for name, value in state.items():
                    setattr(one, name, value)
        for body, load in zip(bodies, loads, strict=True):
            if body.present:
                self._dynamics.make_room()
                if body.object_id in self._loose:
                    self._loose.discard(body.object_id)
                    self._dynamics.wake([body.object_id])
            else:
                self._dynamics.still(body.object_id)
                self._let_go(load)
        if any(body.carrier is not None for body in bodies):
            self._dynamics.bodies_changed()
        self.version += 1

    def _collect(self) -> None:
        """Update the list of objects: inactive ones are removed, and removed copies are forgotten."""
        for body in self.bodies.values():
            body.removed |= not body.active
        gone = [object_id for object_id, b in self.bodies.items() if b.removed and b.name != b.obj.name]
        for object_id in gone:
            self._dynamics.still(object_id)
            del self.bodies[object_id]
        if gone:
            self._dynamics.bodies_changed()

    def _advance(self, seconds: float, until_asleep: str | None = None) -> None:
        moved = self._dynamics.advance(seconds, lambda name: self._load(self.bodies[name]), until_asleep)
        for name in sorted(moved):
            self._move(self.bodies[name], self.bodies[name].pose)
        if moved:
            self.version += 1

    def _rename(self, bodies: Sequence[Body]) -> None:
        """Make `bodies` those of the world, under the objectIds of their positions."""
        for object_id in list(self._dynamics.awake):
            self._dynamics.still(object_id)
        found = named(bodies)
        self.bodies.clear()
        self.bodies.update(found)
        self._loose.clear()
        self._dynamics.bodies_changed()


def _inside(point: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    return bool(((point >= low) & (point <= high)).all())


def _text(vector: np.ndarray) -> str:
    """Return a vector (3,) as Unity writes it."""
    return f"({vector[0]:.1f}, {vector[1]:.1f}, {vector[2]:.1f})"
