"""Stage `candidates`: scripted changes that might make an episode, drawn for a scene (Algorithm 1, lines 1 and 3). Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ovman.generation import placement
from ovman.generation.placement import FreeFloor
from ovman.generation.roaming import roam
from ovman.generation.script import Script
from ovman.models.candidate import Candidate
from ovman.models.change import Alteration
from ovman.models.geometry import Point, Spawn
from ovman.models.query import Query
from ovman.models.record import DEGREE_DECIMALS, lines
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.scene import Scene, SceneObject
from ovman.models.settings import Settings
from ovman.workflow import seeds

GONE_OR_THERE = frozenset((Relation.APPEARED, Relation.REMOVED))
"""Relations of an instance that is in one of the visits, always in the same place."""


def eligible(scene: Scene) -> Mapping[str, list[SceneObject]]:
    """Movable instances by category, categories with at least two instances."""
    by_category: dict[str, list[SceneObject]] = {}
    for item in scene.objects:
        if item.dynamic:
            by_category.setdefault(item.category, []).append(item)
    return {c: items for c, items in sorted(by_category.items()) if len(items) >= 2}


def targets(by_category: Mapping[str, list[SceneObject]], rng: np.random.Generator) -> Iterator[SceneObject]:
    """An endless sequence of instances, category after category; each instance of a category comes once before any repeats."""
    order = [list(by_category)[k] for k in rng.permutation(len(by_category))]
    queues = {c: [by_category[c][k] for k in rng.permutation(len(by_category[c]))] for c in order}
    turn = 0
    while order:
        for category in order:
            yield queues[category][turn % len(queues[category])]
        turn += 1


def once(order: Iterator[SceneObject], number: int) -> Iterator[SceneObject]:
    """The `number` instances of an endless sequence of them, each where it first comes."""
    seen: set[str] = set()
    while len(seen) < number:
        item = next(order)
        if item.id not in seen:
            seen.add(item.id)
            yield item


def displacement(
    scene: Scene,
    item: SceneObject,
    floor: FreeFloor,
    distance_m: float,
    uncrowded: Callable[[Alteration], bool],
    rng: np.random.Generator,
) -> Alteration | Rejection:
    """`item` put onto free floor or a surface `distance_m` metres away or more, the answer uncrowded; or why it cannot be."""
    everywhere = [
        Alteration(kind="displace", instance=item.id, placement=(spot.x, spot.z), height_m=spot.height_m)
        for spot in placement.spots(scene, item, floor, distance_m, rng)
    ]
    found = list(filter(uncrowded, everywhere))
    if not found:
        return Rejection.CROWDED if everywhere else Rejection.NO_PLACEMENT
    return found[int(rng.integers(min(len(found), 8)))]


def motion(scene: Scene, item: SceneObject, floor: FreeFloor, step_m: float) -> Alteration | Rejection:
    """`item` set off from where it stands, in steps of `step_m` metres; why it cannot be."""
    found = roam(scene, item, floor, step_m)
    return Rejection.CANNOT_MOVE if found is None else Alteration(kind="motion", instance=item.id, roam=found)


def spawn_away(
    floor: FreeFloor,
    keep_from: list[tuple[Point, float]],
    headings: int,
    rng: np.random.Generator,
    boxes: Sequence[tuple[Point, Point, float]] = (),
) -> Spawn | None:
    """A reachable position at least so many metres from each of the points of `keep_from`, and farther than so many metres from
    the rectangle of half extents `half` around a point of `boxes`; None if no position is."""
    free = [
        (x, z)
        for x, z in floor.cells
        if all(np.hypot(x - kx, z - kz) >= metres for (kx, kz), metres in keep_from)
        and all(np.hypot(max(abs(x - kx) - hx, 0.0), max(abs(z - kz) - hz, 0.0)) > metres for (kx, kz), (hx, hz), metres in boxes)
    ]
    if not free:
        return None
    x, z = free[int(rng.integers(len(free)))]
    yaw_deg = round(float(360.0 / headings * rng.integers(headings)), DEGREE_DECIMALS)
    return Spawn(x=round(float(x), 4), z=round(float(z), 4), yaw_deg=yaw_deg)


def draw(
    scene: Scene,
    relation: Relation,
    index: int,
    item: SceneObject,
    distractor: SceneObject | None,
    constants: Settings,
) -> Candidate:
    """One candidate for the target `item`; its field `refused` says why nothing could be drawn for it, or is None.

    index: of the candidate among those of scene and relation. distractor: the instance that is moved in place of the target, for
    STABLE. Deterministic under benchmark.seed.
    """
    rng = seeds.generator(constants.benchmark.seed, "candidate", scene.scene, relation.value, index)
    changed = distractor if distractor is not None else item
    floor = FreeFloor.of(scene, changed, constants.primitives.step_m)
    script = Script(scene, Query(item.category, relation), item.id)
    apart_m, clearance_m = constants.candidates.crowding_m, constants.candidates.spawn_clearance_m
    gone = Alteration(kind="disable", instance=item.id)
    first: tuple[Alteration, ...] = (gone,) if relation is Relation.APPEARED else ()
    second: tuple[Alteration, ...] = (gone,) if relation is Relation.REMOVED else ()
    refused: Rejection | None = None
    if relation is Relation.MOVING:
        drawn = motion(scene, changed, floor, constants.mover.step_m)
    elif first or second:
        drawn = Rejection.CROWDED if script.crowded(first, second, apart_m) else gone
    else:
        drawn = displacement(
            scene, changed, floor, constants.candidates.delta_min_m, lambda made: not script.crowded((), (made,), apart_m), rng
        )
    if isinstance(drawn, Rejection):
        refused = drawn
    elif drawn is not gone:
        second = (drawn,)
    keep_from: list[tuple[Point, float]] = [((item.position.x, item.position.z), clearance_m)]
    boxes: list[tuple[Point, Point, float]] = []
    for alteration in second:
        if alteration.placement is not None:
            keep_from.append((alteration.placement, clearance_m))
    if relation is not Relation.MOVING:
        at, beyond_m = script.answer(first, second), constants.candidates.spawn_beyond_m
        half = (item.size.x / 2, item.size.z / 2) if relation.current else (0.0, 0.0)
        boxes = [(at, half, beyond_m), (floor.nearest(at), (0.0, 0.0), beyond_m)]
    spawn = spawn_away(floor, keep_from, constants.tour.headings, rng, boxes)
    if spawn is None and refused is None:
        refused = Rejection.NO_SPAWN
    return Candidate(
        id=f"{scene.scene}/{relation.value}/{index:04d}",
        scene=scene.scene,
        relation=relation,
        category=item.category,
        target=item.id,
        distractor=None if distractor is None else distractor.id,
        first=first,
        second=second,
        spawn=spawn,
        refused=refused,
    )


def candidates(scene: Scene, constants: Settings) -> list[Candidate]:
    """All candidates of a scene, relation after relation; a relation that no category can serve has none.

    Every relation draws its targets itself. APPEARED and REMOVED draw an instance once: it is gone or there, and a second draw
    would be the same pair of tours.
    """
    by_category = eligible(scene)
    drawn = []
    for relation in Relation:
        rng = seeds.generator(constants.benchmark.seed, "targets", scene.scene, relation.value)
        # With a third instance that stays, the stable one would not be unique (Eq. 2).
        pool = {c: items for c, items in by_category.items() if relation is not Relation.STABLE or len(items) == 2}
        if not pool:
            continue
        order = once(targets(pool, rng), sum(map(len, pool.values()))) if relation in GONE_OR_THERE else targets(pool, rng)
        for index, item in zip(range(getattr(constants.candidates.draws, relation.value)), order, strict=False):
            others = [o for o in pool[item.category] if o.id != item.id]
            drawn.append(draw(scene, relation, index, item, others[0] if relation is Relation.STABLE else None, constants))
    return drawn


def run(scene_file: Path, constants: Settings, output: Path) -> None:
    """Write the candidates of the scene in `scene_file` for all splits, a JSON line each."""
    from ovman.generation import multi  # draws with this module's functions

    (scene,) = Scene.read(scene_file)
    drawn = candidates(scene, constants)
    for split in constants.splits.values():
        drawn += multi.candidates(scene, split, constants)
    output.write_text(lines(drawn), encoding="utf-8")
    print(f"{scene_file.stem}: {len(drawn)} candidates", flush=True)
