"""The reference agent's grounding and rules: properties, thresholds, fallbacks and ties."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Evidence, Query, Relation, UniformBox, UniformPick
from ovman.agents.reference.agents import answer_positions, draw
from ovman.agents.reference.association import Association, associate
from ovman.agents.reference.reasoning import (
    answer_two_visits,
    decide,
    decide_by_last_sighting,
    decide_by_spread,
    ground,
    ground_query,
    pick_grounded,
    similarities,
)
from ovman.perception.clusters import Cluster, ObjectMap
from ovman.records.task import Instance, WorldState
from ovman.settings import Settings
from tests.arms import CONFIG

GATE, TAU, SPREAD = CONFIG.association.gate_m, CONFIG.admissibility.tau_m, CONFIG.association.track_spread_m
PAST = (Relation.FORMER, Relation.REMOVED)
STATIC = tuple(relation for relation in Relation if relation is not Relation.MOVING)
NO_CANDIDATE = Abstention(AbstentionReason.NO_CANDIDATE)
NOTHING = Abstention(AbstentionReason.NOTHING_GROUNDED)

# Grounding --------------------------------------------------------------------------------------------------------------------

vectors = st.lists(st.integers(-4, 4).map(lambda step: step / 4), min_size=2, max_size=2).map(np.array)


@given(st.lists(vectors, max_size=9), vectors, st.integers(0, 8).map(lambda step: step / 16))
def test_the_noun_means_what_is_at_most_the_margin_less_similar_than_the_best(features, noun, margin):
    """Similarities are exact in binary, so differences of exactly the margin occur."""
    s = [float(np.dot(f, noun)) for f in features]
    assert ground(features, noun, margin) == tuple(i for i, one in enumerate(s) if max(s) - one <= margin)


def test_similarity_does_not_depend_on_the_neighbours():
    features = np.random.default_rng(0).normal(size=(37, 129))
    noun = np.random.default_rng(1).normal(size=129)
    alone = [similarities(features[[i]], noun)[0] for i in range(len(features))]
    assert similarities(features, noun).tolist() == alone


def test_without_a_noun_every_object_is_meant():
    objects = ObjectMap.of([cluster(0.0, 0.0), cluster(1.0, 0.0, one_hot(1))])
    assert ground_query(Query("", Relation.MOVED), SimpleNamespace(), objects, "first") == (0, 1)
    assert ground_query(Query("", Relation.MOVED), SimpleNamespace(), ObjectMap.of([]), "first") == ()


# Rules ------------------------------------------------------------------------------------------------------------------------

coordinate = st.integers(-80, 80).map(lambda step: step * 0.05)
homes = st.lists(st.tuples(coordinate, coordinate), min_size=0, max_size=5, unique=True)


def ask(relation, p_1, p_2):
    return decide(relation, p_1, p_2, associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0), TAU)


@given(homes, st.tuples(coordinate, coordinate), st.integers(0, 4))
def test_a_displacement_beyond_the_gate_is_found_under_exact_positions(home, place, index):
    """gamma < Delta_min: a displaced instance does not match its own visit-1 position, so both of its ends are the answers."""
    assume(home)
    before = home[index % len(home)]
    rest = [p for p in home if p != before]
    assume(math.dist(before, place) >= CONFIG.candidates.delta_min_m)
    # Neither end near another instance, which would compete for the match.
    assume(all(math.dist(p, place) >= GATE and math.dist(p, before) >= GATE for p in rest))
    p_1, p_2 = [*rest, before], [place, *rest]
    assert ask(Relation.MOVED, p_1, p_2) == Answer(*place)
    assert ask(Relation.FORMER, p_1, p_2) == Answer(*before)


@given(homes, homes, st.sampled_from(STATIC), st.randoms(use_true_random=False))
def test_answers_come_from_the_visit_of_the_relation_whatever_the_order(p_1, p_2, relation, random):
    answer = ask(relation, p_1, p_2)
    if isinstance(answer, Answer):
        assert (answer.x, answer.z) in (p_1 if relation in PAST else p_2)
    assert answer == ask(relation, random.sample(p_1, len(p_1)), random.sample(p_2, len(p_2)))


@given(homes, homes, st.tuples(coordinate, coordinate))
def test_visits_swapped_swap_the_relations(p_1, p_2, place):
    assert ask(Relation.APPEARED, p_1, p_2) == ask(Relation.REMOVED, p_2, p_1)
    found = associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0)
    mirrored = Association(tuple(sorted((j, i) for i, j in found.pairs)), found.unmatched_2, found.unmatched_1)
    assert decide(Relation.MOVED, p_1, p_2, found, TAU) == decide(Relation.FORMER, p_2, p_1, mirrored, TAU)
    if place not in p_1:
        assert ask(Relation.APPEARED, p_1, [*p_1, place]) == ask(Relation.REMOVED, [place, *p_1], p_1) == Answer(*place)


lattice = st.tuples(st.integers(-1, 1), st.integers(-1, 1)).map(lambda at: (at[0] * TAU / 2, at[1] * TAU / 2))


def by_definition(relation, p_1, p_2, found):
    """The rules of the paper and their fallbacks, written out: candidates with the smallest key first, the reason without one."""
    past, reason = relation in PAST, AbstentionReason
    own, others, alone = (p_1, p_2, found.unmatched_1) if past else (p_2, p_1, found.unmatched_2)
    pairs = [(math.dist(p_1[i], p_2[j]), p_1[i], p_2[j]) for i, j in found.pairs]
    if relation is Relation.STABLE:
        best = min(((apart, end, start) for apart, start, end in pairs), default=None)
        return reason.NO_CANDIDATE if best is None else reason.DISPLACEMENT_ABOVE_TAU if best[0] >= TAU else best[1]
    if alone:
        if not others and len(alone) > 1:
            return reason.NO_COUNTERPART
        return min((-min((math.dist(own[k], other) for other in others), default=0.0), own[k]) for k in alone)[1]
    if relation in (Relation.APPEARED, Relation.REMOVED) or not pairs:
        return reason.NO_CANDIDATE
    apart, *ends = min((-apart, start, end) for apart, start, end in pairs)
    return ends[not past] if -apart >= TAU else reason.DISPLACEMENT_BELOW_TAU


SWAPPED = [((0.0, 0.0), (TAU / 2, 0.0)), ((TAU / 2, 0.0), (0.0, 0.0))]
ends = st.lists(st.tuples(lattice, lattice), max_size=3)


@settings(max_examples=300)
@given(ends, st.lists(lattice, max_size=2), st.lists(lattice, max_size=2), st.sampled_from(STATIC))
@example(SWAPPED, [], [], Relation.STABLE)
@example([(tuple(2 * x for x in start), tuple(2 * x for x in end)) for start, end in SWAPPED], [], [], Relation.MOVED)
def test_the_rules_are_those_of_the_paper_ties_and_thresholds_included(pairs, left_1, left_2, relation):
    """Places are multiples of half of tau, so that equal candidates and displacements of exactly tau occur."""
    p_1, p_2 = [*(start for start, _ in pairs), *left_1], [*(end for _, end in pairs), *left_2]
    count = len(pairs)
    found = Association(tuple((k, k) for k in range(count)), tuple(range(count, len(p_1))), tuple(range(count, len(p_2))))
    expected = by_definition(relation, p_1, p_2, found)
    expected = Abstention(expected) if isinstance(expected, AbstentionReason) else Answer(*expected)
    assert decide(relation, p_1, p_2, found, TAU) == expected


# MOVING -----------------------------------------------------------------------------------------------------------------------

steps = st.tuples(st.integers(0, 1), st.integers(0, 1)).map(lambda at: (at[0] * SPREAD, at[1] * SPREAD))


@settings(max_examples=100)
@given(st.lists(st.lists(steps, max_size=3), max_size=4))
def test_with_true_positions_the_track_of_the_largest_spread_answers_if_that_exceeds_its_threshold(tracks):
    spreads = [(-max(math.dist(a, b) for a in track for b in track), track[-1]) for track in tracks if track]
    if not spreads:
        expected = NO_CANDIDATE
    else:
        spread, last = min(spreads)
        expected = Answer(*last) if -spread > SPREAD else Abstention(AbstentionReason.NO_MOTION)
    assert decide_by_spread(tracks, SPREAD) == expected


@settings(max_examples=100)
@given(st.lists(st.tuples(st.lists(steps, min_size=1, max_size=3), st.integers(0, 3), st.booleans()), max_size=5))
def test_under_perception_the_unmatched_cluster_that_was_seen_latest_is_answered(clusters):
    alone = [k for k, (*_, matched) in enumerate(clusters) if not matched]
    latest = min(((-clusters[k][1], clusters[k][0][-1]) for k in alone), default=None)
    tracks, last_seen = [track for track, *_ in clusters], [seen for _, seen, _ in clusters]
    expected = NO_CANDIDATE if latest is None else Answer(*latest[1])
    assert decide_by_last_sighting(tracks, last_seen, Association((), (), tuple(alone))) == expected


# From maps --------------------------------------------------------------------------------------------------------------------

CATEGORIES = ("Chair", "Vase", "Book")
REACHABLE = [(-5.0, -4.0), (5.0, 4.0), (0.0, 0.0)]


def constants(similarity_margin: float = 0.03, gate_m: float = GATE, feature_scale_m: float = 2.0) -> Settings:
    changed = {"association.gate_m": gate_m, "association.feature_scale_m": feature_scale_m}
    return CONFIG.with_values({**changed, "grounding.similarity_margin": similarity_margin})


def one_hot(k: int) -> np.ndarray:
    return np.eye(len(CATEGORIES))[k]


def cluster(x: float, z: float, feature=(1.0, 0.0, 0.0), views=(0,), track=None) -> Cluster:
    track = [(x, z)] * len(views) if track is None else track
    return Cluster(np.array([x, z]), np.array(feature, dtype=float), np.array(track, dtype=float), np.array(views))


def asked(relation: Relation, first, second, noun: int = 0, own: Settings = CONFIG):
    maps = ObjectMap.of(first), ObjectMap.of(second)
    grounded = (ground(m.f, one_hot(noun), own.grounding.similarity_margin) for m in maps)
    return answer_two_visits(relation, *maps, *grounded, own)


metres = st.floats(-5, 5).map(lambda value: round(value, 3))
instances = st.lists(st.tuples(st.integers(0, 2), metres, metres), max_size=9, unique_by=lambda item: item[1:])


@given(instances, instances, st.sampled_from(STATIC), st.integers(0, 2))
def test_true_maps_lead_to_the_answer_from_true_positions(first, second, relation, noun):
    # A map without any instance of the category grounds the noun in something else, which positions never do.
    assume(all(any(k == noun for k, *_ in placed) for placed in (first, second)))
    worlds = [
        WorldState(tuple(Instance(str(i), CATEGORIES[k], x, z, ((x, z),)) for i, (k, x, z) in enumerate(placed)))
        for placed in (first, second)
    ]
    clusters = [[cluster(x, z, one_hot(k)) for k, x, z in placed] for placed in (first, second)]
    assert asked(relation, *clusters, noun)[0] == answer_positions(Query(CATEGORIES[noun], relation), *worlds, CONFIG)


unit = st.floats(0, 1.5).map(lambda angle: (np.cos(angle), np.sin(angle), 0.0))
seen = st.lists(st.builds(cluster, metres, metres, unit, st.integers(0, 23).map(lambda v: (v,))), max_size=8)


@given(seen, seen, st.sampled_from(list(Relation)), st.floats(0.3, 3), st.randoms(use_true_random=False))
def test_the_order_of_clusters_does_not_matter_and_pairs_cost_less_than_the_gate(first, second, relation, gate_m, random):
    own = constants(0.2, gate_m)
    answer, evidence = asked(relation, first, second, own=own)
    shuffled = [random.sample(visit, len(visit)) for visit in (first, second)]
    assert asked(relation, *shuffled, own=own)[0] == answer
    for i, j in evidence.pairs:
        assert i in evidence.grounded_1 and j in evidence.grounded_2
        unlike = 1 - first[i].feature @ second[j].feature
        assert np.linalg.norm(first[i].position - second[j].position) + 2.0 * unlike < gate_m + 1e-9


@pytest.mark.parametrize("gate_m", [0.3, 3.0])
def test_objects_are_one_up_to_the_gate_of_the_settings_and_not_at_it(gate_m):
    for apart, pairs in ((gate_m, ()), (float(np.nextafter(gate_m, 0.0)), ((0, 0),))):
        assert asked(Relation.STABLE, [cluster(0.0, 0.0)], [cluster(apart, 0.0)], own=constants(gate_m=gate_m))[1].pairs == pairs


def test_features_tell_apart_instances_that_places_confuse():
    slanted = (0.8, 0.6, 0.0)
    first = [cluster(0.0, 0.0), cluster(0.4, 0.0, slanted)]
    second = [cluster(0.35, 0.0), cluster(0.05, 0.0, slanted)]
    assert asked(Relation.STABLE, first, second, own=constants(0.5))[1].pairs == ((0, 0), (1, 1))
    assert asked(Relation.STABLE, first, second, own=constants(0.5, feature_scale_m=1e-9))[1].pairs == ((0, 1), (1, 0))


def test_a_disagreement_is_of_all_objects_and_read_for_the_grounded_ones():
    first = [cluster(0.0, 0.0, one_hot(1)), cluster(0.0, 0.0), cluster(0.5, 0.0)]
    second = [cluster(0.0, 0.0), cluster(9.0, 0.0, one_hot(1)), cluster(8.0, 0.0, one_hot(1)), cluster(0.5, 0.0)]
    unlike = np.full((3, 4), 0.0)
    unlike[1, 0] = unlike[2, 3] = 1.0
    both, means = (ObjectMap.of(first), ObjectMap.of(second)), ((1, 2), (0, 3))
    assert answer_two_visits(Relation.STABLE, *both, *means, CONFIG)[1].pairs == ((1, 0), (2, 3))
    assert answer_two_visits(Relation.STABLE, *both, *means, CONFIG, unlike)[1].pairs == ((1, 3), (2, 0))


@pytest.mark.parametrize("relation", list(Relation))
def test_empty_maps_abstain_by_name(relation):
    assert asked(relation, [], [])[0] == NOTHING
    outcome, evidence = pick_grounded(relation, ObjectMap.of([]), (), REACHABLE)
    assert outcome == (UniformBox(-5.0, -4.0, 5.0, 4.0) if relation.past else NOTHING) and evidence == Evidence(None, ())


# One visit --------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("relation", list(Relation))
def test_a_single_visit_picks_places_and_for_moving_last_track_points(relation):
    track = np.array([[0.0, 0.0], [3.0, 4.0]])
    objects = ObjectMap(p=np.array([[1.0, 2.0], [9.0, 9.0]]), f=np.eye(2), tracks=(track, track), last_seen=(1, 1))
    outcome, evidence = pick_grounded(relation, objects, (0,), [(0.0, 1.0), (2.0, -1.0)])
    assert (evidence.grounded_1, evidence.grounded_2) == (None, (0,))
    if relation.past:
        assert outcome == UniformBox(0.0, -1.0, 2.0, 1.0)
    else:
        assert outcome == UniformPick(((3.0, 4.0) if relation is Relation.MOVING else (1.0, 2.0),))
        assert pick_grounded(relation, objects, (), [])[0] == NOTHING


def test_a_draw_is_uniform_and_an_abstention_stays_one():
    rng = np.random.default_rng(0)
    pick = UniformPick(((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)))
    counts = np.bincount([int(draw(pick, rng).x) for _ in range(3000)], minlength=3)
    assert counts.sum() == 3000 and np.abs(counts - 1000).max() < 120
    points = np.array([(p.x, p.z) for p in (draw(UniformBox(-4.0, 2.0, -2.0, 4.0), rng) for _ in range(2000))])
    assert (points >= (-4, 2)).all() and (points <= (-2, 4)).all() and points.mean(axis=0) == pytest.approx((-3.0, 3.0), abs=0.06)
    assert draw(NOTHING, rng) is NOTHING
