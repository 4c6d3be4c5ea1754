"""What is drawn for a scene: who is eligible, in which turns, and what a spawn keeps clear of."""

from __future__ import annotations

import math
from itertools import islice, pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.generation.candidates import cycle_targets, draw_candidates
from ovman.generation.drawing import Drawing, draw_spawn, group_eligible
from ovman.generation.placement import FreeFloor
from ovman.records.scene import Alteration
from ovman.records.task import Relation
from ovman.settings import MAIN
from tests.arms import CONFIG
from tests.generation.test_placement import room, thing


def of_main(scene, constants):
    return draw_candidates(scene, Drawing.of(constants.splits[MAIN], scene, constants), constants)


def test_the_clearance_of_a_spawn_is_inclusive_from_the_target_and_from_placements():
    item, clearance_m = thing("chair|1", "Chair", 0.0, 0.0), CONFIG.candidates.spawn_clearance_m
    scene = room(item, cells=8)
    floor, rng = FreeFloor.of(scene, item, 0.25, scene.waypoints), np.random.default_rng(0)
    placed = Alteration(kind="displace", instance=item.id, placement=(1.75, 1.75), height_m=0.0)
    for second in ((), (placed,)):
        far = {
            c
            for c in scene.reachable
            if all(math.dist(c, p) >= clearance_m for p in [(0.0, 0.0), (1.75, 1.75)][: 1 + len(second)])
        }
        drawn = [draw_spawn(item, second, floor, CONFIG, rng) for _ in range(400)]
        assert {(s.x, s.z) for s in drawn} == far and ((clearance_m, 0.0) in far)
        assert {s.yaw_deg for s in drawn} == {round(360 / CONFIG.tour.headings * k, 2) for k in range(CONFIG.tour.headings)}
    everywhere = [placed.model_copy(update={"placement": (x, z)}) for x in (0.5, 1.5) for z in (0.5, 1.5)]
    assert draw_spawn(item, everywhere, floor, CONFIG, rng) is None


def test_two_movable_instances_make_a_category_eligible():
    things = [thing("b|1", "B", 1, 1), thing("b|2", "B", 2, 1), thing("a|1", "A", 1, 2), thing("a|2", "A", 2, 2, moveable=False)]
    assert {c: [o.id for o in items] for c, items in group_eligible(room(*things)).items()} == {"B": ["b|1", "b|2"]}
    pickable = things[3].model_copy(update={"pickupable": True})
    assert list(group_eligible(room(*things[:3], pickable))) == ["A", "B"]


def test_categories_take_turns_and_instances_within_them():
    by_category = {c: [thing(f"{c}|{k}", c, 1, 1) for k in range(n)] for c, n in (("A", 2), ("B", 3))}
    drawn = [item.id for item in islice(cycle_targets(by_category, np.random.default_rng(1)), 12)]
    assert {k[0] for k in drawn[::2]} | {k[0] for k in drawn[1::2]} == {"A", "B"}
    assert all(a[0] != b[0] for a, b in pairwise(drawn))
    turns = {c: [k for k in drawn if k[0] == c] for c in "AB"}
    assert turns["A"][:2] == turns["A"][2:4] and len(set(turns["A"][:2])) == 2
    assert turns["B"][:3] == turns["B"][3:] and len(set(turns["B"][:3])) == 3


def test_stable_takes_categories_of_two_and_moves_the_other():
    pair = [thing("a|1", "A", 0.5, 0.5), thing("a|2", "A", 2.0, 2.0)]
    three = [thing(f"b|{k}", "B", 1.0 + k, 0.5) for k in range(3)]
    drawn = of_main(room(*pair, *three), CONFIG)
    stable = [c for c in drawn if c.relation is Relation.STABLE]
    assert len(stable) == CONFIG.splits[MAIN].draws.stable
    assert {c.category for c in stable} == {"A"} and {(c.target, c.distractor) for c in stable} == {
        ("a|1", "a|2"),
        ("a|2", "a|1"),
    }
    assert all(a.instance == c.distractor for c in stable for a in c.second)
    assert all(c.distractor is None for c in drawn if c.relation is not Relation.STABLE)
    assert {c.relation for c in of_main(room(*three), CONFIG)} == set(Relation) - {Relation.STABLE}
    assert of_main(room(pair[0]), CONFIG) == []


def test_appeared_and_removed_draw_an_instance_once_each_in_an_order_of_its_own():
    things = [thing(f"{c}|{k}", c, 0.3 + 1.5 * k, 0.5) for c in "ab" for k in range(4)]
    drawn = of_main(room(*things), CONFIG)
    came, went = ([c.target for c in drawn if c.relation is relation] for relation in (Relation.APPEARED, Relation.REMOVED))
    assert sorted(came) == sorted(went) == sorted(item.id for item in things) and came != went
    fewer = of_main(room(*things), drawing(appeared=3, removed=0))
    assert [c.target for c in fewer if c.relation in (Relation.APPEARED, Relation.REMOVED)] == came[:3]
    for c in drawn:
        assert len(c.first + c.second) == 1 or c.refused is not None or c.relation is Relation.MOVING
        assert all(a.kind == "disable" and a.instance == c.target for a in c.first)


def drawing(**draws):
    """The settings with other draws, none of the relations that are not named."""
    main = CONFIG.splits[MAIN]
    drawn = main.draws.model_copy(update={r.value: draws.get(r.value, 0) for r in Relation})
    return CONFIG.model_copy(update={"splits": {MAIN: main.model_copy(update={"draws": drawn})}})


@settings(max_examples=6)
@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=2, max_size=5, unique=True))
def test_no_spawn_is_near_the_change(places):
    things = [thing(f"a|{k}", "A", 0.25 * i, 0.25 * j, size=(0.2, 0.3, 0.2)) for k, (i, j) in enumerate(places)]
    at = {o.id: (o.position.x, o.position.z) for o in things}
    for c in of_main(room(*things, cells=24), drawing(moved=3, former=4, stable=3, appeared=9, removed=9)):
        change = [at[c.target], *(a.placement for a in c.second if a.placement is not None)]
        if c.refused is None:
            assert min(math.dist((c.spawn.x, c.spawn.z), point) for point in change) >= CONFIG.candidates.spawn_clearance_m
