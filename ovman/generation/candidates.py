"""Stage `candidates`: scripted changes that might make an episode, drawn for a scene (Algorithm 1, lines 1 and 3). Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ovman.generation import placement
from ovman.generation.placement import FreeFloor
from ovman.models.candidate import Candidate
from ovman.models.change import Alteration, Lane
from ovman.models.geometry import Point, Spawn
from ovman.models.record import DEGREE_DECIMALS, lines
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.scene import Scene, SceneObject
from ovman.models.settings import Settings
from ovman.sim.change import AGENT_RADIUS_M
from ovman.workflow import seeds

SHARE_OF_LANES = 4
"""A mover gets one of the nearest quarter of the lanes that it could take."""
LANE_SAMPLING_M = 0.1
"""Distance between the points of a lane that a spawn keeps clear of, metres."""


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


def _displacement(
    scene: Scene, item: SceneObject, floor: FreeFloor, distance_m: float, rng: np.random.Generator
) -> Alteration | None:
    found = placement.spots(scene, item, floor, distance_m, rng)
    if not found:
        return None
    spot = found[int(rng.integers(min(len(found), 8)))]
    return Alteration(kind="displace", instance=item.id, placement=(spot.x, spot.z), height_m=spot.height_m)


def _motion(scene: Scene, item: SceneObject, floor: FreeFloor, minimum_m: float, rng: np.random.Generator) -> Alteration | None:
    found = placement.lanes(item, floor, minimum_m)
    if not found:
        return None
    lane = found[int(rng.integers(max(1, len(found) // SHARE_OF_LANES)))]
    height_m = round(scene.floor_y + placement.ABOVE_SURFACE_M, 4)
    return Alteration(kind="motion", instance=item.id, height_m=height_m, lane=lane)


def _beside(lane: Lane, item: SceneObject, clearance_m: float) -> list[tuple[Point, float]]:
    """The beginning of a lane with the spawn clearance, and points along it that the agent's body must leave to the mover."""
    body_m = AGENT_RADIUS_M + np.hypot(item.size.x, item.size.z) / 2
    along = np.arange(0.0, lane.length_m + LANE_SAMPLING_M, LANE_SAMPLING_M).clip(max=lane.length_m)
    return [(lane.at(0.0), clearance_m), *((lane.at(metres), body_m + LANE_SAMPLING_M) for metres in along)]


def _spawn(floor: FreeFloor, keep_from: list[tuple[Point, float]], headings: int, rng: np.random.Generator) -> Spawn | None:
    """A reachable position at least so many metres from each of the points of `keep_from`; None if no position is."""
    free = [(x, z) for x, z in floor.cells if all(np.hypot(x - kx, z - kz) >= metres for (kx, kz), metres in keep_from)]
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
    first: tuple[Alteration, ...] = ()
    second: tuple[Alteration, ...] = ()
    refused: Rejection | None = None
    clearance_m = constants.candidates.spawn_clearance_m
    keep_from: list[tuple[Point, float]] = [((item.position.x, item.position.z), clearance_m)]
    if relation is Relation.APPEARED:
        first = (Alteration(kind="disable", instance=item.id),)
    elif relation is Relation.REMOVED:
        second = (Alteration(kind="disable", instance=item.id),)
    else:
        if relation is Relation.MOVING:
            alteration = _motion(scene, changed, floor, constants.mover.lane_min_m, rng)
        else:
            alteration = _displacement(scene, changed, floor, constants.candidates.delta_min_m, rng)
        if alteration is None:
            refused = Rejection.NO_LANE if relation is Relation.MOVING else Rejection.NO_PLACEMENT
        else:
            second = (alteration,)
            if alteration.placement is not None:
                keep_from.append((alteration.placement, clearance_m))
            elif alteration.lane is not None:
                keep_from += _beside(alteration.lane, changed, clearance_m)
    spawn = _spawn(floor, keep_from, constants.tour.headings, rng)
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

    APPEARED and REMOVED draw the same targets: one is the other with its visits swapped, so each recorded tour serves both.
    """
    by_category = eligible(scene)
    drawn = []
    for relation in Relation:
        drawn_as = Relation.APPEARED if relation is Relation.REMOVED else relation
        rng = seeds.generator(constants.benchmark.seed, "targets", scene.scene, drawn_as.value)
        # With a third instance that stays, the stable one would not be unique (Eq. 2).
        pool = {c: items for c, items in by_category.items() if relation is not Relation.STABLE or len(items) == 2}
        if not pool:
            continue
        for index, item in zip(range(getattr(constants.candidates.draws, relation.value)), targets(pool, rng), strict=False):
            others = [o for o in pool[item.category] if o.id != item.id]
            drawn.append(draw(scene, relation, index, item, others[0] if relation is Relation.STABLE else None, constants))
    return drawn


def run(scene_file: Path, constants: Settings, output: Path) -> None:
    """Write the candidates of the scene in `scene_file`, a JSON line each."""
    (scene,) = Scene.read(scene_file)
    drawn = candidates(scene, constants)
    output.write_text(lines(drawn), encoding="utf-8")
    print(f"{scene_file.stem}: {len(drawn)} candidates", flush=True)
