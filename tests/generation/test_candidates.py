"""What is drawn for a scene: who is eligible, in which turns, and what a spawn keeps clear of."""

from __future__ import annotations

from itertools import islice, pairwise

import numpy as np
import pytest

from ovman.generation.candidates import LANE_SAMPLING_M, _beside, _spawn, candidates, eligible, targets
from ovman.generation.placement import FreeFloor
from ovman.models.change import Lane
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.scene import Scene
from ovman.sim.change import AGENT_RADIUS_M
from tests.arms import CONFIG
from tests.generation.test_placement import thing


def room(*objects, cells=12) -> Scene:
    """An empty room of so many cells of 0.25 m a side."""
    reachable = tuple((0.25 * i, 0.25 * j) for i in range(cells) for j in range(cells))
    return Scene(
        scene="Room", start=(0.0, 0.0), floor_y=0.0, reachable=reachable, components=(len(reachable),),
        waypoints=((0.0, 0.0),), objects=objects,
    )  # fmt: skip


@pytest.mark.parametrize("length_m", [0.55, 1.0, 2.03, 2.1])
def test_the_body_of_a_mover_is_left_its_whole_lane(length_m):
    """A point at least every LANE_SAMPLING_M, both ends among them, and the clearance at the beginning."""
    item = thing("chair|1", "Chair", 0.0, 0.0, size=(0.6, 1.0, 0.8))
    lane = Lane(x_0=1.0, z_0=2.0, x_1=1.0, z_1=2.0 + length_m)
    (beginning, clearance_m), *body = _beside(lane, item, 1.5)
    assert (beginning, clearance_m) == ((1.0, 2.0), 1.5)
    along = [z - 2.0 for (_, z), _ in body]
    assert along[0] == 0.0 and along[-1] == pytest.approx(length_m)
    assert all(0.0 <= b - a <= LANE_SAMPLING_M + 1e-9 for a, b in pairwise(along))
    assert [metres for _, metres in body] == pytest.approx([AGENT_RADIUS_M + 0.5 + LANE_SAMPLING_M] * len(body))
    assert {x for (x, _), _ in body} == {1.0}


def test_the_clearance_of_a_spawn_is_inclusive_from_every_point():
    item = thing("chair|1", "Chair", 9.0, 9.0)
    floor = FreeFloor.of(room(item, cells=3), item, 0.25)
    rng = np.random.default_rng(0)
    found = {(s.x, s.z) for _ in range(60) if (s := _spawn(floor, [((0.0, 0.0), 0.5), ((0.5, 0.5), 0.25)], 4, rng))}
    assert found == {(0.5, 0.0), (0.0, 0.5), (0.5, 0.25), (0.25, 0.5)}
    headings = {s.yaw_deg for _ in range(60) if (s := _spawn(floor, [], 3, rng))}
    assert headings == {0.0, 120.0, 240.0}
    assert {s.yaw_deg for _ in range(90) if (s := _spawn(floor, [], 7, rng))} == {round(360 / 7 * k, 2) for k in range(7)}
    assert _spawn(floor, [((0.25, 0.25), 0.4)], 4, rng) is None


def test_two_movable_instances_make_a_category_eligible():
    things = [thing("b|1", "B", 1, 1), thing("b|2", "B", 2, 1), thing("a|1", "A", 1, 2), thing("a|2", "A", 2, 2, moveable=False)]
    assert {c: [o.id for o in items] for c, items in eligible(room(*things)).items()} == {"B": ["b|1", "b|2"]}
    pickable = things[3].model_copy(update={"pickupable": True})
    assert list(eligible(room(*things[:3], pickable))) == ["A", "B"]


def test_categories_take_turns_and_instances_within_them():
    by_category = {c: [thing(f"{c}|{k}", c, 1, 1) for k in range(n)] for c, n in (("A", 2), ("B", 3))}
    drawn = [item.id for item in islice(targets(by_category, np.random.default_rng(1)), 12)]
    assert {k[0] for k in drawn[::2]} | {k[0] for k in drawn[1::2]} == {"A", "B"}
    assert all(a[0] != b[0] for a, b in pairwise(drawn))
    turns = {c: [k for k in drawn if k[0] == c] for c in "AB"}
    assert turns["A"][:2] == turns["A"][2:4] and len(set(turns["A"][:2])) == 2
    assert turns["B"][:3] == turns["B"][3:] and len(set(turns["B"][:3])) == 3


def test_stable_takes_categories_of_two_and_moves_the_other():
    pair = [thing("a|1", "A", 0.5, 0.5), thing("a|2", "A", 2.0, 2.0)]
    three = [thing(f"b|{k}", "B", 1.0 + k, 0.5) for k in range(3)]
    drawn = candidates(room(*pair, *three), CONFIG)
    stable = [c for c in drawn if c.relation is Relation.STABLE]
    assert len(stable) == CONFIG.candidates.draws.stable
    assert {c.category for c in stable} == {"A"} and {(c.target, c.distractor) for c in stable} == {
        ("a|1", "a|2"),
        ("a|2", "a|1"),
    }
    assert all(a.instance == c.distractor for c in stable for a in c.second)
    assert all(c.distractor is None for c in drawn if c.relation is not Relation.STABLE)
    assert {c.relation for c in candidates(room(*three), CONFIG)} == set(Relation) - {Relation.STABLE}
    assert candidates(room(pair[0]), CONFIG) == []


def test_what_cannot_be_drawn_is_named():
    """A room of four cells has no free place, no lane, and no spawn away from the target."""
    small = room(thing("a|1", "A", 0.0, 0.0), thing("a|2", "A", 0.25, 0.25), cells=2)
    refused = {c.relation: c.refused for c in candidates(small, CONFIG)}
    assert refused == {
        Relation.MOVED: Rejection.NO_PLACEMENT,
        Relation.FORMER: Rejection.NO_PLACEMENT,
        Relation.STABLE: Rejection.NO_PLACEMENT,
        Relation.MOVING: Rejection.NO_LANE,
        Relation.APPEARED: Rejection.NO_SPAWN,
        Relation.REMOVED: Rejection.NO_SPAWN,
    }


def test_heights_have_four_decimals():
    scene = room(*(thing(f"a|{k}", "A", 0.3 + k, 0.5, size=(0.2, 0.2, 0.2)) for k in range(3)), cells=16)
    scene = scene.model_copy(update={"floor_y": 0.123456})
    heights = {(a.kind, a.height_m) for c in candidates(scene, CONFIG) for a in c.first + c.second}
    assert {("displace", 0.1735), ("motion", 0.1735), ("disable", None)} == heights


def test_appeared_and_removed_are_each_other_with_the_visits_swapped():
    drawn = candidates(room(*(thing(f"a|{k}", "A", 0.3 + k, 0.5) for k in range(3))), CONFIG)
    came = [(c.target, c.first) for c in drawn if c.relation is Relation.APPEARED]
    went = [(c.target, c.second) for c in drawn if c.relation is Relation.REMOVED]
    assert came == went and all(a.kind == "disable" and a.instance == k for k, (a,) in came)
