"""Candidates with one scripted change, and the stage that draws all candidates of a scene (Algorithm 1, lines 1, 3). Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.generation import crossed, multi
from ovman.generation.drawing import Drawing, draw_displacement, draw_motion, draw_spawn, group_eligible, places_of_agent
from ovman.generation.placement import FreeFloor
from ovman.processes import map_items
from ovman.records.record import lines
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.records.task import Rejection, Relation
from ovman.records.trial import Candidate
from ovman.settings import Settings

GONE_OR_THERE = frozenset((Relation.APPEARED, Relation.REMOVED))
"""Relations of an instance that is present in one of the visits, always in the same place."""


def cycle_targets(by_category: Mapping[str, list[SceneObject]], rng: np.random.Generator) -> Iterator[SceneObject]:
    """Yield instances without end, category after category; each instance of a category comes once before any repeats."""
    order = [list(by_category)[k] for k in rng.permutation(len(by_category))]
    queues = {c: [by_category[c][k] for k in rng.permutation(len(by_category[c]))] for c in order}
    turn = 0
    while order:
        for category in order:
            yield queues[category][turn % len(queues[category])]
        turn += 1


def draw_candidate(
    scene: Scene,
    relation: Relation,
    item: SceneObject,
    distractor: SceneObject | None,
    index: int,
    drawing: Drawing,
    constants: Settings,
) -> Candidate:
    """Draw one candidate about `item`; its field `refused` says why nothing could be drawn for it, or is None.

    distractor: for STABLE the instance that moves instead of the target. index: of the candidate among those of scene, split and
    relation. Deterministic under benchmark.seed.
    """
    changed = distractor or item
    name = drawing.id(scene.scene, relation.value, index)
    rng = seeds.generator(constants.benchmark.seed, "candidate", *drawing.split.stream, scene.scene, relation.value, index)
    floor = FreeFloor.of(scene, changed, constants.primitives.step_m, places_of_agent(scene, drawing.tours))
    gone = Alteration(kind="disable", instance=item.id)
    first: tuple[Alteration, ...] = (gone,) if relation is Relation.APPEARED else ()
    second: tuple[Alteration, ...] = (gone,) if relation is Relation.REMOVED else ()
    refused: Rejection | None = None
    if relation is Relation.MOVING:
        drawn = draw_motion(scene, changed, floor, constants.mover.step_m)
    elif first or second:
        drawn = gone
    else:
        drawn = draw_displacement(scene, changed, floor, constants.candidates.delta_min_m, rng)
    if isinstance(drawn, Rejection):
        refused = drawn
    elif drawn is not gone:
        second = (drawn,)
    begins = draw_spawn(item, second, floor, constants, rng)
    if begins is None and refused is None:
        refused = Rejection.NO_SPAWN
    return Candidate(
        id=name,
        split=drawing.split.name,
        scene=scene.scene,
        relation=relation,
        category=item.category,
        target=item.id,
        distractor=None if distractor is None else distractor.id,
        tours=drawing.tours_of(name, constants.benchmark.seed),
        first=first,
        second=second,
        others={},
        spawn=begins,
        rules=drawing.split.rules,
        refused=refused,
    )


def draw_candidates(scene: Scene, drawing: Drawing, constants: Settings) -> list[Candidate]:
    """Draw all candidates of a scene with one scripted change, relation after relation.

    A relation that no category can serve has none. Every relation draws its own targets. APPEARED and REMOVED draw an instance
    once, since a second draw would be the same pair of tours.
    """
    by_category = group_eligible(scene)
    split = drawing.split
    drawn: list[Candidate] = []
    for relation in Relation:
        rng = seeds.generator(constants.benchmark.seed, "targets", *split.stream, scene.scene, relation.value)
        # With a third instance that stays, the stable one would not be unique (Eq. 2).
        pool = {c: items for c, items in by_category.items() if relation is not Relation.STABLE or len(items) == 2}
        if not pool:
            continue
        order = cycle_targets(pool, rng)
        if relation in GONE_OR_THERE:
            order = iter(dict.fromkeys(islice(order, len(pool) * max(map(len, pool.values())))))
        lacking = getattr(split.draws, relation.value)
        most = lacking * (split.tries or 1)
        for index, item in enumerate(islice(order, most)):
            if lacking <= 0:
                break
            away = next((o for o in by_category[item.category] if o.id != item.id and relation is Relation.STABLE), None)
            drawn.append(draw_candidate(scene, relation, item, away, index, drawing, constants))
            lacking -= split.tries is None or drawn[-1].refused is None
    return drawn


def run(split: str, scenes_file: Path, settings: Settings, output: Path, workers: int = 1) -> None:
    """Draw the candidates of a split in its scenes and write them to `output`, scene by scene in the order of `scenes_file`."""
    drawn = map_items(partial(_draw, split=split, settings=settings), Scene.read(scenes_file), workers)
    output.write_text("".join(drawn), encoding="utf-8")


def _draw(scene: Scene, split: str, settings: Settings) -> str:
    drawing = Drawing.of(settings.splits[split], scene, settings)
    draw = (
        crossed.draw_candidates if drawing.split.crossed else draw_candidates if drawing.split.single else multi.draw_candidates
    )
    drawn = draw(scene, drawing, settings)
    print(f"{scene.scene}: {len(drawn)} candidates", flush=True)
    return lines(drawn)
