"""What changes beside the scripted change: other categories, as many as asked for, alike, away from it."""

from __future__ import annotations

import math
from collections import Counter
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman import seeds
from ovman.generation.candidates import draw_candidates
from ovman.generation.distractors import PLACED, Surroundings
from ovman.generation.drawing import KIND_OF, Drawing
from ovman.generation.roaming import side
from ovman.generation.sight import Sight
from ovman.records.scene import Roam, Scene
from ovman.records.task import Relation
from ovman.records.trial import Candidate
from ovman.sim.world import Mover, walk
from tests.arms import CONFIG
from tests.episodes import scene_record
from tests.generation.test_placement import scene_of, thing

SPLIT = next(split for split in CONFIG.splits.values() if split.others is not None and split.in_main_job)
TERMS, APART_M = SPLIT.others, CONFIG.candidates.apart_m
SCENES = ("FloorPlan204", "FloorPlan322")


@cache
def drawn_in(name: str) -> tuple[Candidate, ...]:
    """Candidates of a scene that are not refused, of fewer draws than the split asks for."""
    scene = scene_record(name)
    draws = SPLIT.draws.model_copy(update={"former": 8, "moving": 6, "stable": 4})
    drawing = Drawing.of(SPLIT.model_copy(update={"draws": draws}), scene, CONFIG)
    return tuple(c for c in draw_candidates(scene, drawing, CONFIG) if c.refused is None)


def of_kinds(candidate: Candidate) -> dict[str, str]:
    """How each instance changes."""
    return {a.instance: "enable" for a in candidate.first} | {a.instance: a.kind for a in candidate.second}


def places(scene: Scene, candidate: Candidate, instances: set[str]) -> list[tuple[float, float]]:
    """Where the instances are in either visit, as far as that is scripted."""
    put = [a.placement for a in candidate.second if a.instance in instances and a.placement is not None]
    return [(o.position.x, o.position.z) for o in scene.objects if o.id in instances] + put


@pytest.mark.parametrize("name", SCENES)
def test_others_are_of_other_categories_enough_alike_apart_and_as_large(name):
    scene = scene_record(name)
    categories = {o.id: o.category for o in scene.objects}
    volume = {o.id: o.size.x * o.size.y * o.size.z for o in scene.objects}
    assert {c.relation for c in drawn_in(name)} >= {Relation.APPEARED, Relation.REMOVED}
    fewest, most = TERMS.count
    for c in drawn_in(name):
        kinds = of_kinds(c)
        scripted = c.target if c.distractor is None else c.distractor
        assert {*kinds} == {scripted, *c.others} and scripted not in c.others
        assert all(categories[k] == category != c.category for k, category in c.others.items())
        assert fewest <= len(c.others) <= most
        assert kinds[scripted] == KIND_OF[c.relation]
        assert sum(kinds[k] == kinds[scripted] for k in c.others) >= getattr(TERMS.alike, c.relation.value)
        assert all(kind != "motion" or c.relation is Relation.MOVING for kind in kinds.values())
        for one, other in product(places(scene, c, {scripted, c.target}), places(scene, c, {*c.others})):
            assert math.dist(one, other) >= APART_M, c.id
        assert all(1 / TERMS.size_ratio <= volume[k] / volume[scripted] <= TERMS.size_ratio for k in c.others)


def test_neither_the_largest_change_nor_the_smallest_nor_the_only_one_of_several_tells_the_scripted_one():
    """Of those alike, by what is foreseen of them; as the scripted one is, many are of a category with several, those that stand
    free of their like first."""
    larger: Counter[int] = Counter()
    several = []
    for name in SCENES:
        scene = scene_record(name)
        by_id, number = {o.id: o for o in scene.objects}, Counter(o.category for o in scene.objects)
        beside = Surroundings(scene, Drawing.of(SPLIT, scene, CONFIG).tours, TERMS, CONFIG)
        for c in (c for c in drawn_in(name) if c.relation is not Relation.MOVING):
            scripted, kind = c.target if c.distractor is None else c.distractor, KIND_OF[c.relation]
            kinds = of_kinds(c)
            alike = [k for k in c.others if kinds[k] == kind]
            shows_sr = beside.shows_sr(by_id[scripted], kind)
            larger[sum(beside.shows_sr(by_id[k], kind) > shows_sr for k in alike)] += 1
            several += [number[by_id[k].category] > 1 for k in alike]
    least = min(larger[above] for above in range(3))
    assert least >= sum(larger.values()) / 10, larger
    assert sum(several) > len(several) * 0.4


@pytest.mark.parametrize("name", SCENES)
def test_what_changes_alike_is_as_free_of_its_like_as_the_answer(name):
    """Where it stood for FORMER, where it comes to for MOVED, where it is or was for APPEARED and REMOVED."""
    scene = scene_record(name)
    at = {o.id: (o.position.x, o.position.z) for o in scene.objects}
    for c in (c for c in drawn_in(name) if c.relation in PLACED):
        kinds, put = of_kinds(c), {a.instance: a.placement for a in c.second if a.placement is not None}
        for k in (k for k in c.others if kinds[k] == KIND_OF[c.relation]):
            place = put[k] if c.relation is Relation.MOVED else at[k]
            like = [o.id for o in scene.objects if o.category == c.others[k] and o.id != k]
            first = [at[i] for i in like if kinds.get(i) != "enable"] if c.relation.past else []
            second = [put.get(i, at[i]) for i in like if kinds.get(i) != "disable"]
            assert all(math.dist(place, where) > CONFIG.candidates.crowding_m for where in first + second), c.id


def test_movers_are_given_floors_on_which_they_do_not_meet_and_come_far_enough():
    scene = scene_record("FloorPlan204")
    half_m = {o.id: math.hypot(o.size.x, o.size.z) / 2 for o in scene.objects}
    moving = [c for c in drawn_in("FloorPlan204") if c.relation is Relation.MOVING]
    assert moving
    for c in moving:
        floors, names = zip(*((a.roam, a.instance) for a in c.second if a.kind == "motion"), strict=True)
        assert len(floors) >= 2 and names[0] == c.target
        points = [np.array([floor.at(cell) for cell in floor.cells]) for floor in floors]
        gaps = np.hypot(*(points[0][:, None] - points[1]).transpose(2, 0, 1))
        assert gaps.min() >= half_m[names[0]] + half_m[names[1]], c.id
        rng = seeds.generator(CONFIG.benchmark.seed, "mover", c.id, "tour")
        steps = len(c.tours.second.waypoints) * c.tours.second.headings
        for floor, stream in zip(floors, [rng, *rng.spawn(len(floors) - 1)], strict=True):
            path = walk(Mover.setting_off(floor, stream), CONFIG.mover, stream, steps)
            gone_m = max(math.dist(mover.position, (floor.x, floor.z)) for mover in path)
            assert gone_m >= CONFIG.candidates.mover_min_m, c.id


@settings(max_examples=5)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 1.25))
def test_two_sides_of_a_floor_are_apart_and_each_holds_its_own_start(x, z, clear_m):
    cells = [(i, j) for i in range(-12, 13) for j in range(-12, 13)]
    here, there = Roam.over(0.0, 0.0, 0.25, cells), Roam.over(x, z, 0.25, cells)
    one, other = side(here, (x, z), clear_m), side(there, (0.0, 0.0), clear_m)
    if math.hypot(x, z) < 2 * clear_m:
        assert one is None and other is None
    elif one is not None and other is not None:
        assert one.cells <= here.cells and (0, 0) in one.cells
        assert min(math.dist(one.at(a), other.at(b)) for a, b in product(one.cells, other.cells)) >= 2 * clear_m - 1e-3


def test_what_stands_behind_something_is_not_foreseen_to_be_seen():
    box = thing("box|1", "Box", 3.0, 0.0, size=(0.5, 1.0, 0.5), y=0.5)
    wall = thing("wall|1", "Shelf", 1.5, 0.0, size=(0.1, 2.5, 4.0), y=1.25)
    alone, hidden = (scene_of(things, [(0.0, 0.0)]) for things in ((box,), (box, wall)))
    seen = Sight.of(alone, [(0.0, 0.0)]).solid_angle(box, (3.0, 0.5, 0.0))
    assert seen > 0.0 == Sight.of(hidden, [(0.0, 0.0)]).solid_angle(box, (3.0, 0.5, 0.0))
    assert Sight.of(hidden, [(0.0, 0.0), (3.0, 3.0)]).solid_angle(box, (3.0, 0.5, 0.0)) > 0.0
    farther = Sight.of(alone, [(0.0, 0.0)]).solid_angle(box, (5.0, 0.5, 0.0))
    assert 0.0 < farther < seen
