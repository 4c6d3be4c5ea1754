"""Stage `candidates`: scripted changes that might make an episode, drawn for a scene (Algorithm 1, lines 1 and 3). Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.generation import others, placement
from ovman.generation.beside import Beside
from ovman.generation.others import NOBODY
from ovman.generation.placement import FreeFloor
from ovman.generation.protocol import Drawing, drawings, keeps_free
from ovman.generation.roaming import roam
from ovman.generation.script import Script
from ovman.generation.spawning import spawn
from ovman.records.candidate import Candidate
from ovman.records.change import Alteration
from ovman.records.query import Query
from ovman.records.record import lines
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.records.scene import Scene, SceneObject
from ovman.settings import Settings

GONE_OR_THERE = frozenset((Relation.APPEARED, Relation.REMOVED))
"""Relations of an instance that is in one of the visits, always in the same place."""
AMONG = 8
"""A displacement is drawn among so many places, or among those that there are."""


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
    foreseen: Callable[[Alteration], bool] | None = None,
) -> Alteration | Rejection:
    """`item` put onto free floor or a surface `distance_m` metres away or more, the answer uncrowded; or why it cannot be.

    foreseen: whether a tour is foreseen to record it there; such places go first.
    """
    everywhere = [
        Alteration(kind="displace", instance=item.id, placement=(spot.x, spot.z), height_m=spot.height_m)
        for spot in placement.spots(scene, item, floor, distance_m, rng)
    ]
    found = list(filter(uncrowded, everywhere))
    if not found:
        return Rejection.CROWDED if everywhere else Rejection.NO_PLACEMENT
    if foreseen is not None:
        found = list(islice(filter(foreseen, found), AMONG)) or found
    return found[int(rng.integers(min(len(found), AMONG)))]


def motion(scene: Scene, item: SceneObject, floor: FreeFloor, step_m: float) -> Alteration | Rejection:
    """`item` set off from where it stands, in steps of `step_m` metres; why it cannot be."""
    found = roam(scene, item, floor, step_m)
    return Rejection.CANNOT_MOVE if found is None else Alteration(kind="motion", instance=item.id, roam=found)


@dataclass(frozen=True)
class Asked:
    """What a candidate is about: its relation, its target, and for STABLE the instance that moves in the target's place."""

    relation: Relation
    target: SceneObject
    distractor: SceneObject | None

    @property
    def changed(self) -> SceneObject:
        """The instance of the scripted change."""
        return self.target if self.distractor is None else self.distractor


def draw(
    scene: Scene, asked: Asked, index: int, drawing: Drawing, constants: Settings, beside: Beside | None = None
) -> Candidate:
    """One candidate; its field `refused` says why nothing could be drawn for it, or is None.

    index: of the candidate among those of scene, split and relation. beside: what may change beside the scripted instance, for a
    split that has such. Deterministic under benchmark.seed.
    """
    relation, item, changed = asked.relation, asked.target, asked.changed
    name = drawing.id(scene.scene, relation.value, index)
    rng = seeds.generator(constants.benchmark.seed, "candidate", *drawing.names, scene.scene, relation.value, index)
    floor = FreeFloor.of(scene, changed, constants.primitives.step_m, keeps_free(scene, drawing.tours))
    script = Script(scene, Query(item.category, relation), item.id)
    apart_m = constants.candidates.crowding_m
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
            scene,
            changed,
            floor,
            constants.candidates.delta_min_m,
            lambda made: not script.crowded((), (made,), apart_m),
            rng,
            None if beside is None else lambda made: beside.recorded_at(changed, made),
        )
    if isinstance(drawn, Rejection):
        refused = drawn
    elif drawn is not gone:
        second = (drawn,)
    also = NOBODY
    if beside is not None and refused is None:
        walk_rng = seeds.generator(constants.benchmark.seed, *seeds.tour_movers(name))
        found = others.draw(beside, changed, relation, script, first, second, constants, rng, walk_rng)
        if isinstance(found, Rejection):
            refused = found
        else:
            first, second, also = found.first, found.second, found.categories
    begins = spawn(script, item, first, second, floor, constants, rng, also)
    if begins is None and refused is None:
        refused = Rejection.NO_SPAWN
    return Candidate(
        id=name,
        split=drawing.split,
        scene=scene.scene,
        relation=relation,
        category=item.category,
        target=item.id,
        distractor=None if asked.distractor is None else asked.distractor.id,
        tours=drawing.of_candidate(name, constants.benchmark.seed),
        first=first,
        second=second,
        others=also,
        spawn=begins,
        refused=refused,
    )


def candidates(scene: Scene, drawing: Drawing, constants: Settings) -> list[Candidate]:
    """All candidates of a scene with one scripted change, relation after relation.

    A relation that no category can serve has none.

    Every relation draws its targets itself. Where nothing else changes, APPEARED and REMOVED draw an instance once: it is gone or
    there, and a second draw would be the same pair of tours.
    """
    by_category = eligible(scene)
    beside = None if drawing.others is None else Beside(scene, drawing.tours, drawing.others, constants)
    drawn: list[Candidate] = []
    for relation in Relation:
        rng = seeds.generator(constants.benchmark.seed, "targets", *drawing.names, scene.scene, relation.value)
        # With a third instance that stays, the stable one would not be unique (Eq. 2).
        pool = {c: items for c, items in by_category.items() if relation is not Relation.STABLE or len(items) == 2}
        if beside is not None:
            pool = {c: left for c, items in pool.items() if (left := [k for k in items if beside.serves(k, relation)])}
        if not pool:
            continue
        order = targets(pool, rng)
        if relation in GONE_OR_THERE and beside is None:
            order = once(order, sum(map(len, pool.values())))
        lacking = getattr(drawing.draws, relation.value)
        most = lacking if drawing.tries is None else lacking * drawing.tries
        for index, item in enumerate(islice(order, most)):
            if lacking <= 0:
                break
            away = [o for o in by_category[item.category] if o.id != item.id]
            asked = Asked(relation, item, away[0] if relation is Relation.STABLE else None)
            drawn.append(draw(scene, asked, index, drawing, constants, beside))
            lacking -= drawing.tries is None or drawn[-1].refused is None
    return drawn


def run(scene_file: Path, constants: Settings, output: Path) -> None:
    """Write the candidates of the scene in `scene_file` for all splits that have it, a JSON line each."""
    from ovman.generation import multi  # draws with this module's functions

    (scene,) = Scene.read(scene_file)
    drawn: list[Candidate] = []
    for drawing in drawings(scene, constants):
        drawn += (candidates if drawing.changes == (1,) else multi.candidates)(scene, drawing, constants)
    output.write_text(lines(drawn), encoding="utf-8")
    print(f"{scene_file.stem}: {len(drawn)} candidates", flush=True)
