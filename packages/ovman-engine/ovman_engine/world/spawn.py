"""Places movable objects on receptacles at random. Candidates come from boxes; physics then checks each one.

Source: contract, section 4 (InitialRandomSpawn, GetSpawnCoordinatesAboveReceptacle). World frame as in `floorplan`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ovman_engine.bodies.body import Body, Pose
from ovman_engine.bodies.static_scene import StaticScene
from ovman_engine.bodies.surfaces import Level, Pieces, holding
from ovman_engine.plan.floorplan import rotation_matrix
from ovman_engine.world.placement import RECEPTACLES
from ovman_engine.world.world import World

if TYPE_CHECKING:
    from ovman_engine.physics.physics import Model

ABOVE_M = 0.05
"""Height of spawn points above their surface."""
APART_M = 0.05
"""Least distance between spawn points."""
ROOMS = ((0.08, 0.12), (0.06, 0.12), (0.04, 0.1), (0.02, 0.06), (0.0, 0.05))
"""Half width and height that must be free around a spawn point: the largest that the receptacle offers anywhere."""
GAP_M = 0.002
"""Height of a randomly placed object above its surface."""
SUNK_M, PROUD_M = 0.08, 0.015
"""How far the true surface may be below and above the face of its box."""
OVERLAP_M = 0.001
"""Deepest overlap of a placed object with any other."""
STRAIGHT = 0.94
"""An object leans if no axis of it is nearer to the vertical than this cosine."""
SLENDER = 5.0
"""An object that is so many times higher than thin is laid down: it would not stand."""
SETTLED_S = 2.0
"""Simulated time that physics gets if objects are not stationary."""
OUTSIDE = frozenset(
    [
        "ArmChair",
        "Bed",
        "Box",
        "Chair",
        "CoffeeTable",
        "CounterTop",
        "Desk",
        "DiningTable",
        "Dresser",
        "Floor",
        "Ottoman",
        "Pan",
        "Plate",
        "Shelf",
        "ShelvingUnit",
        "SideTable",
        "Sink",
        "SinkBasin",
        "Sofa",
        "StoveBurner",
        "TVStand",
        "Toilet",
    ]
)
"""Types on which objects are visible."""


def points(world: World, receptacle: Body) -> np.ndarray:
    """Free points (N, 3) above the surfaces of `receptacle`, on a grid with spacing APART_M or more."""
    surfaces = holding(world, receptacle)
    for half, height in ROOMS:
        found = [_thinned(level, level.fitting((half, half), height)) for level in surfaces]
        if sum(map(len, found)):
            return np.concatenate(
                [np.insert(f, 1, level.height + ABOVE_M, axis=1) for f, level in zip(found, surfaces, strict=True)]
            )
    return np.zeros((0, 3))


def _thinned(level: Level, found: np.ndarray) -> np.ndarray:
    step = max(int(np.ceil(APART_M / level.spacing - 1e-6)), 1)
    cells = np.rint((found - level.corner) / level.spacing).astype(int)
    if not len(cells):
        return found
    kept = ((cells - cells[len(cells) // 2]) % step == 0).all(axis=1)
    return found[kept]


def seen(world: World, view, targets: np.ndarray) -> np.ndarray:
    """(N,) bool: which of the points `targets` (N, 3) a view shows unoccluded. `view`: camera.View."""
    away = (targets - view.position) @ view.axes().T
    reach = away[:, 2] * np.tan(np.radians(view.fov_deg) / 2)
    inside = (away[:, 2] > 0) & (np.abs(away[:, 1]) <= reach) & (np.abs(away[:, 0]) <= reach * view.width / view.height)
    bodies = (b for b in world.bodies.values() if b.present and b.obj.type != "Floor")
    boxes = Pieces.of(StaticScene.of(world.plan), bodies)
    start = np.einsum("nij,ni->nj", boxes.rotation, view.position - boxes.centre)
    for k in np.flatnonzero(inside):
        along = np.einsum("nij,ni->nj", boxes.rotation, targets[k] - boxes.centre) - start
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = (-boxes.half - start) / along, (boxes.half - start) / along
        enter, leave = np.fmin(one, two).max(axis=1), np.fmax(one, two).min(axis=1)
        inside[k] = not ((enter < leave) & (enter > 0) & (leave < 1)).any()
    return inside


@dataclass(frozen=True)
class SpawnOptions:
    """Arguments of InitialRandomSpawn. Ids and types are AI2-THOR's; None means all."""

    seed: int = 0
    only_outside: bool = False
    stationary: bool = True
    attempts: int = 5
    no_receptacles: frozenset[str] = frozenset()
    no_objects: frozenset[str] = frozenset()
    objects: frozenset[str] | None = None
    receptacles: frozenset[str] | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    """Type -> number of objects of it"""
    moveable: bool = False
    """Whether objects that can be pushed but not picked up are moved as well"""


def spawn(world: World, wishes: SpawnOptions) -> int:
    """Places every selected object on a random receptacle for its type. Returns the number of placed objects.

    The others stay where they are; copies without a place are discarded. The result is a function of the world and the wishes.
    """
    rng = np.random.default_rng([wishes.seed & 0xFFFFFFFF, wishes.seed < 0])
    asked = _limited([b for b in world.bodies.values() if _asked(b, wishes)], wishes.counts)
    copies = _copies(world, asked, wishes.counts, rng)
    subjects = [*asked, *copies]
    subjects = [subjects[k] for k in rng.permutation(len(subjects))]
    homes = _receptacles(world, wishes, {b.object_id for b in subjects}, rng)
    if not subjects or not homes:
        world.discard(copies)
        return 0
    with world.trial([b.object_id for b in subjects]) as model:
        poses = _Search(world, model, subjects, copies, wishes, rng).places(homes)
    world.discard([b for b in copies if b.object_id not in poses])
    world.rearrange(poses, wishes.stationary)
    return len(poses)


def _asked(body: Body, wishes: SpawnOptions) -> bool:
    movable = body.obj.pickupable or (wishes.moveable and body.obj.moveable)
    wanted = wishes.objects is None or body.object_id in wishes.objects
    known = body.obj.type in RECEPTACLES or not body.obj.pickupable
    return movable and wanted and known and body.present and body.carrier is None and body.object_id not in wishes.no_objects


def _limited(bodies: Sequence[Body], counts: Mapping[str, int]) -> list[Body]:
    """Return the first objects of each type, up to the wished number."""
    taken: dict[str, int] = {}
    out = []
    for body in bodies:
        kind = body.obj.type
        taken[kind] = taken.get(kind, 0) + 1
        if taken[kind] <= counts.get(kind, taken[kind]):
            out.append(body)
    return out


def _copies(world: World, asked: Sequence[Body], counts: Mapping[str, int], rng: np.random.Generator) -> list[Body]:
    """Copy of the selected objects, up to the wished number of each type."""
    out = []
    for kind, count in counts.items():
        originals = [b for b in asked if b.obj.type == kind]
        for k in range(count - len(originals) if originals else 0):
            out.append(world.duplicate(originals[int(rng.integers(len(originals)))], k))
    return out


def _receptacles(world: World, wishes: SpawnOptions, moving: Collection[str], rng: np.random.Generator) -> list[Body]:
    """Receptacles in the order in which they are tried: random, one of each type at a time."""
    by_type: dict[str, list[Body]] = {}
    for body in world.bodies.values():
        record = body.obj.record
        holds = body.present and record["receptacle"] and (record["isOpen"] or not record["openable"])
        named = wishes.receptacles is None or body.object_id in wishes.receptacles
        fitting = body.obj.type not in wishes.no_receptacles and (body.obj.type in OUTSIDE or not wishes.only_outside)
        if holds and named and fitting and body.object_id not in moving:
            by_type.setdefault(body.obj.type, []).append(body)
    queues = [[by_type[kind][k] for k in rng.permutation(len(by_type[kind]))] for kind in sorted(by_type)]
    queues = [queues[k] for k in rng.permutation(len(queues))]
    return [queue[k] for k in range(max(map(len, queues), default=0)) for queue in queues if k < len(queue)]


class _Search:
    """One random arrangement. A placed object is an obstacle for the next one."""

    def __init__(
        self,
        world: World,
        model: Model,
        subjects: Sequence[Body],
        copies: Sequence[Body],
        wishes: SpawnOptions,
        rng: np.random.Generator,
    ) -> None:
        self._world, self._model, self._wishes, self._rng = world, model, wishes, rng
        self._subjects = {b.object_id: b for b in subjects}
        self._levels: dict[str, tuple[Level, ...]] = {}
        self._low, self._high = np.full((len(subjects), 3), np.inf), np.full((len(subjects), 3), -np.inf)
        self._row = {b.object_id: k for k, b in enumerate(subjects)}
        made = {b.object_id for b in copies}
        for name, k in self._row.items():
            if name in made:
                model.set_present(name, False)
            else:
                self._low[k], self._high[k] = self._subjects[name].box.bounds()

    def places(self, homes: Sequence[Body]) -> dict[str, Pose]:
        """Map the objectId to the pose of every object for which one of `homes` has a place."""
        found = {}
        for name, body in self._subjects.items():
            kinds = RECEPTACLES.get(body.obj.type, frozenset(["Floor"]))
            order = [h for h in homes if h.obj.type in kinds]
            if len(order) > 1:
                # a new order for each object, so that they do not crowd on the first receptacles
                first = int(self._rng.integers(len(order)))
                order = order[first:] + order[:first]
            for home in order:
                pose = self._on(body, home)
                if pose is not None:
                    found[name] = pose
                    self._low[self._row[name]], self._high[self._row[name]] = body.box_at(pose).bounds()
                    break
        return found

    def _on(self, body: Body, home: Body) -> Pose | None:
        if home.object_id not in self._levels:
            self._levels[home.object_id] = holding(self._world, home, self._subjects)
        surfaces = self._levels[home.object_id]
        turns = [_upright(body, quarter) for quarter in self._rng.permutation(4).tolist()]
        spots = []
        for level in surfaces:
            for turn in turns[:2]:
                low, high = body.box_at(Pose(np.zeros(3), turn)).bounds()
                middle, half = (low + high) / 2, (high - low) / 2
                for x, z in level.fitting(half[[0, 2]], float(2 * half[1]) + PROUD_M):
                    spots.append((np.array([x - middle[0], level.height - low[1], z - middle[2]]), turn, half, middle))
        order = self._rng.permutation(len(spots))
        tried = 0
        for k in order.tolist():
            position, turn, half, middle = spots[k]
            centre = position + middle
            if ((centre - half < self._high) & (centre + half > self._low)).all(axis=1)[self._others(body)].any():
                continue
            pose = self._checked(body, home, Pose(position, turn), centre)
            if pose is not None:
                return pose
            tried += 1
            if tried >= self._wishes.attempts:
                break
        return None

    def _others(self, body: Body) -> np.ndarray:
        return np.arange(len(self._row)) != self._row[body.object_id]

    def _checked(self, body: Body, home: Body, pose: Pose, centre: np.ndarray) -> Pose | None:
        """Return the pose lowered onto the true surface, if that belongs to `home` and nothing is in the way."""
        name, foot = body.object_id, float(body.box_at(pose).bounds()[0][1])
        surface = self._model.below(np.array([centre[0], foot + PROUD_M, centre[2]]), PROUD_M + SUNK_M, but=name)
        own = {home.object_id, home.carrier, home.obj.type if home.obj.type == "Floor" else None}
        if surface is None or surface[1] not in own:
            return None
        pose = Pose(pose.position + [0.0, surface[0] + GAP_M - foot, 0.0], pose.rotation)
        self._model.set_present(name, True)
        self._model.set_box(name, body.box_at(pose))
        self._model.forward()
        if any(depth > OVERLAP_M for _, depth in self._model.touching(name)):
            self._restore(body)
            return None
        return pose

    def _restore(self, body: Body) -> None:
        there = bool(np.isfinite(self._low[self._row[body.object_id]]).all())
        self._model.set_present(body.object_id, there)
        self._model.set_box(body.object_id, body.box)
        self._model.forward()


def _upright(body: Body, quarter: int) -> np.ndarray:
    """Rotation (3, 3) of a placed body: its current one, after `quarter` quarter turns about the vertical.

    A leaning body is placed upright, as AI2-THOR's assets stand; a slender one is laid on its broad side.
    """
    turn = rotation_matrix(np.array([0.0, 90.0 * quarter, 0.0]))
    up, thin = int(np.abs(body.box.rotation[1]).argmax()), int(body.box.half.argmin())
    if body.box.half[up] > SLENDER * body.box.half[thin]:
        from_box = body.box.rotation.T @ body.pose.rotation
        lying = np.roll(np.eye(3), 1 - thin, axis=0)
        return turn @ lying @ from_box
    return turn @ body.pose.rotation if np.abs(body.box.rotation[1, up]) > STRAIGHT else turn
