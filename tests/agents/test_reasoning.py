"""From maps to an answer."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Evidence, UniformBox, UniformPick
from ovman.agents.reference.agents import answer_positions, draw
from ovman.agents.reference.reasoning import answer_two_visits, ground, ground_query, pick_grounded, pick_instance
from ovman.evaluation.scores import success_probability
from ovman.perception.clusters import Cluster
from ovman.perception.object_map import ObjectMap
from ovman.settings import Settings
from ovman.task import Instance, Query, Relation, WorldState


def constants(similarity_margin: float = 0.03, gate_m: float = 1.25, feature_scale_m: float = 2.0) -> Settings:
    association = {"gate_m": gate_m, "feature_scale_m": feature_scale_m, "track_spread_m": 0.4}
    grounding, admissibility = {"similarity_margin": similarity_margin}, {"tau_m": 0.75}
    return Settings.partial({"association": association, "grounding": grounding, "admissibility": admissibility}, "test")


CONSTANTS = constants()
CATEGORIES = ("Chair", "Vase", "Book")
REACHABLE = [(-5.0, -4.0), (5.0, 4.0), (0.0, 0.0)]
STILL = [relation for relation in Relation if relation is not Relation.MOVING]


def one_hot(k: int) -> np.ndarray:
    return np.eye(len(CATEGORIES))[k]


def cluster(x: float, z: float, feature=(1.0, 0.0, 0.0), views=(0,), track=None) -> Cluster:
    track = [(x, z)] * len(views) if track is None else track
    return Cluster(np.array([x, z]), np.array(feature, dtype=float), np.array(track, dtype=float), np.array(views))


coordinate = st.floats(-5, 5).map(lambda value: round(value, 3))
instances = st.lists(st.tuples(st.integers(0, 2), coordinate, coordinate), max_size=9, unique_by=lambda item: item[1:])


def clusters_of(placed) -> list[Cluster]:
    return [cluster(x, z, one_hot(k)) for k, x, z in placed]


def world_of(placed) -> WorldState:
    return WorldState(tuple(Instance(str(i), CATEGORIES[k], x, z, ((x, z),)) for i, (k, x, z) in enumerate(placed)))


def asked(relation: Relation, first, second, noun: int = 0, constants: Settings = CONSTANTS):
    maps = ObjectMap.of(first), ObjectMap.of(second)
    return answer_two_visits(
        relation, *maps, *(ground(m.f, one_hot(noun), constants.grounding.similarity_margin) for m in maps), constants
    )


@given(instances, instances, st.sampled_from(STILL), st.integers(0, 2))
def test_maps_that_are_true_lead_to_the_answer_of_positions_handed_over(first, second, relation, noun):
    # A map without any instance of the category grounds the noun in something else, which positions never do.
    assume(all(any(k == noun for k, *_ in placed) for placed in (first, second)))
    expected = answer_positions(Query(CATEGORIES[noun], relation), world_of(first), world_of(second), CONSTANTS)
    assert asked(relation, clusters_of(first), clusters_of(second), noun)[0] == expected


unit = st.floats(0, 1.5).map(lambda angle: (np.cos(angle), np.sin(angle), 0.0))
seen = st.lists(st.builds(cluster, coordinate, coordinate, unit, st.integers(0, 23).map(lambda v: (v,))), max_size=8)


@given(seen, seen, st.sampled_from(list(Relation)), st.randoms(use_true_random=False))
def test_the_order_of_the_clusters_is_of_no_consequence(first, second, relation, random):
    answer, evidence = asked(relation, first, second)
    shuffled = [random.sample(visit, len(visit)) for visit in (first, second)]
    again, found = asked(relation, *shuffled)
    assert again == answer

    def named(evidence: Evidence, visits):
        pairs = [(id(visits[0][i]), id(visits[1][j])) for i, j in evidence.pairs]
        means = [{id(visit[i]) for i in g} for visit, g in zip(visits, (evidence.grounded_1, evidence.grounded_2), strict=True)]
        return sorted(pairs), means

    # Clusters that are alike in everything may change places; then only the answer is theirs.
    alike = any(len({(*c.position, *c.feature) for c in visit}) < len(visit) for visit in (first, second))
    assert alike or named(found, shuffled) == named(evidence, (first, second))


@given(seen, seen, st.sampled_from(list(Relation)), st.floats(0.3, 3))
def test_pairs_are_grounded_and_cost_less_than_the_gate(first, second, relation, gate_m):
    _, evidence = asked(relation, first, second, constants=constants(0.2, gate_m))
    for i, j in evidence.pairs:
        one, other = first[i], second[j]
        assert i in evidence.grounded_1 and j in evidence.grounded_2
        assert np.linalg.norm(one.position - other.position) + 2.0 * (1 - one.feature @ other.feature) < gate_m + 1e-9


def test_features_tell_apart_what_places_confuse():
    slanted = (0.8, 0.6, 0.0)
    wide, blind = constants(0.5), constants(0.5, feature_scale_m=1e-9)
    first = [cluster(0.0, 0.0), cluster(0.4, 0.0, slanted)]
    second = [cluster(0.35, 0.0), cluster(0.05, 0.0, slanted)]
    assert asked(Relation.STABLE, first, second, constants=wide)[1].pairs == ((0, 0), (1, 1))
    assert asked(Relation.STABLE, first, second, constants=blind)[1].pairs == ((0, 1), (1, 0))


def test_a_disagreement_is_of_all_objects_and_read_for_what_is_grounded():
    """By features the two of each visit are alike; the disagreement pairs each with the farther one."""
    first = [cluster(0.0, 0.0, one_hot(1)), cluster(0.0, 0.0), cluster(0.5, 0.0)]
    second = [cluster(0.0, 0.0), cluster(9.0, 0.0, one_hot(1)), cluster(8.0, 0.0, one_hot(1)), cluster(0.5, 0.0)]
    unlike = np.full((3, 4), 0.0)
    unlike[1, 0] = unlike[2, 3] = 1.0
    maps, means = (ObjectMap.of(first), ObjectMap.of(second)), ((1, 2), (0, 3))
    assert answer_two_visits(Relation.STABLE, *maps, *means, CONSTANTS)[1].pairs == ((1, 0), (2, 3))
    assert answer_two_visits(Relation.STABLE, *maps, *means, CONSTANTS, unlike)[1].pairs == ((1, 3), (2, 0))


def test_a_noun_that_is_withheld_means_every_object():
    objects = ObjectMap.of([cluster(0.0, 0.0), cluster(1.0, 0.0, one_hot(1)), cluster(2.0, 0.0, one_hot(2))])

    class Nothing:
        """A context of which nothing is read."""

    assert ground_query(Query("", Relation.MOVED), Nothing(), objects, "first") == (0, 1, 2)
    assert ground_query(Query("", Relation.MOVED), Nothing(), ObjectMap.of([]), "first") == ()


@pytest.mark.parametrize("relation", list(Relation))
def test_empty_maps_abstain_by_name(relation):
    nothing = Abstention(AbstentionReason.NOTHING_GROUNDED)
    assert asked(relation, [], [])[0] == nothing
    outcome, evidence = pick_grounded(relation, ObjectMap.of([]), (), REACHABLE)
    assert outcome == (UniformBox(-5.0, -4.0, 5.0, 4.0) if relation.past else nothing)
    assert evidence == Evidence(None, ())


def test_one_empty_map_leaves_what_the_other_says():
    here = [cluster(1.0, 2.0)]
    assert asked(Relation.APPEARED, [], here)[0] == Answer(1.0, 2.0) == asked(Relation.REMOVED, here, [])[0]
    assert asked(Relation.MOVED, here, [])[0] == Abstention(AbstentionReason.NO_CANDIDATE)


def test_moving_is_where_the_unmatched_cluster_that_was_seen_latest_was_seen_last():
    first = [cluster(0.0, 0.0)]
    second = [
        cluster(0.1, 0.0, views=(20, 23)),
        cluster(3.0, 0.0, views=(2, 5)),
        cluster(4.0, 0.0, views=(7, 9), track=[(3.8, 0.0), (4.2, 0.1)]),
    ]
    answer, evidence = asked(Relation.MOVING, first, second)
    assert answer == Answer(4.2, 0.1) and evidence.pairs == ((0, 0),)


grounded_clusters = st.lists(
    st.builds(
        lambda x, z, steps: cluster(x, z, views=tuple(range(1 + len(steps))), track=[(x, z), *((x + d, z) for d in steps)]),
        coordinate,
        coordinate,
        st.lists(st.floats(-1, 1), max_size=3),
    ),
    min_size=1,
    max_size=6,
)


@given(grounded_clusters, st.data())
def test_the_single_visit_succeeds_as_often_as_its_candidates_are_right(found, data):
    relation = data.draw(st.sampled_from([r for r in Relation if not r.past]))
    means = data.draw(st.sets(st.integers(0, len(found) - 1), min_size=1).map(sorted))
    target = (data.draw(coordinate), data.draw(coordinate))
    pick, _ = pick_grounded(relation, ObjectMap.of(found), means, REACHABLE)
    points = [found[i].track[-1] if relation is Relation.MOVING else found[i].position for i in means]
    right = sum(np.hypot(x - target[0], z - target[1]) <= 1.0 for x, z in points)
    draws = np.random.default_rng(0)
    assert success_probability(pick, target, 1.0, samples=1, generator=draws) == pytest.approx(right / len(points))


def test_past_relations_succeed_as_often_as_the_box_is_near_the_answer():
    pick, _ = pick_grounded(Relation.REMOVED, ObjectMap.of([cluster(0.0, 0.0)]), (0,), REACHABLE)
    answer = (4.5, 3.2)
    fine = [np.hypot(x - answer[0], z - answer[1]) <= 1.0 for x, z in product(np.linspace(-5, 5, 1001), np.linspace(-4, 4, 801))]
    draws = np.random.default_rng(0)
    assert success_probability(pick, answer, 1.0, samples=100_000, generator=draws) == pytest.approx(np.mean(fine), abs=2e-3)


def test_a_pick_is_uniform_and_an_abstention_stays_one():
    rng = np.random.default_rng(0)
    pick = UniformPick(((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)))
    counts = np.bincount([int(draw(pick, rng).x) for _ in range(3000)], minlength=3)
    assert counts.sum() == 3000 and np.abs(counts - 1000).max() < 120
    box = UniformBox(-4.0, 2.0, -2.0, 4.0)
    points = np.array([(p.x, p.z) for p in (draw(box, rng) for _ in range(2000))])
    assert (points >= (-4, 2)).all() and (points <= (-2, 4)).all()
    assert points.mean(axis=0) == pytest.approx((-3.0, 3.0), abs=0.06)
    gone = Abstention(AbstentionReason.NOTHING_GROUNDED)
    assert draw(gone, rng) is gone


@pytest.mark.parametrize("relation", [relation for relation in Relation if not relation.past])
def test_current_relations_pick_among_last_track_points(relation):
    pick = pick_instance(relation, [[(3.0, 0.0)], [(0.0, 0.0), (0.0, 1.0)], []], reachable=[(0.0, 0.0)])
    assert pick == UniformPick(((0.0, 1.0), (3.0, 0.0)))


@pytest.mark.parametrize("relation", [relation for relation in Relation if relation.past])
def test_past_relations_know_only_what_is_reachable(relation):
    assert pick_instance(relation, [[(9.0, 9.0)]], reachable=[(0.0, 1.0), (2.0, -1.0), (1.0, 0.0)]) == UniformBox(
        0.0, -1.0, 2.0, 1.0
    )
    with pytest.raises(ValueError, match="reachable"):
        pick_instance(relation, [], reachable=[])
