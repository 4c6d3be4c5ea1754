"""The reference agent's grounding and rules: properties, thresholds, fallbacks and ties."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given
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
    spread_m,
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

BAND = 0.03
vectors = st.lists(st.floats(-1, 1), min_size=4, max_size=4).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)
units = vectors.map(lambda v: v / np.linalg.norm(v))
maps = st.lists(units, min_size=1, max_size=12).map(np.stack)
UNIT = np.array([1.0, 0.0])
MAP = np.array([[0.5, 0.0], [0.25, 1.0], [0.75, 0.0], [0.5, 3.0]])
"""Similarities 0.5, 0.25, 0.75, 0.5: exact in binary."""


@given(maps, units, st.floats(0, 2), st.randoms(use_true_random=False))
def test_a_band_holds_the_best_whatever_the_order_of_the_map(features, noun, band, random):
    s = [float(np.dot(f, noun)) for f in features]
    best = ground(features, noun, 0)
    assert best and all(s[i] == pytest.approx(max(s)) for i in best) and {*best} <= {*ground(features, noun, band)}
    assert ground(features, noun, 2.001) == tuple(range(len(features)))
    order = random.sample(range(len(features)), len(features))
    assert sorted(order[i] for i in ground(features[order], noun, BAND)) == list(ground(features, noun, BAND))


@pytest.mark.parametrize("margin, means", [(0.0, (2,)), (0.2499, (2,)), (0.25, (0, 2, 3)), (0.5, (0, 1, 2, 3))])
def test_the_margin_of_the_grounding_is_inclusive(margin, means):
    assert ground(MAP, UNIT, margin) == means


def test_an_empty_map_of_any_shape_means_nothing():
    for empty in ([], np.zeros((0, 0)), np.zeros((0, 2))):
        assert ground(empty, UNIT, 0.1) == () and similarities(empty, UNIT).shape == (0,)


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


def decided(relation, p_1, p_2, association):
    return decide(relation, p_1, p_2, association, TAU)


def ask(relation, p_1, p_2):
    return decided(relation, p_1, p_2, associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0))


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


@given(homes, homes)
def test_visits_swapped_swap_the_relations(p_1, p_2):
    assert ask(Relation.APPEARED, p_1, p_2) == ask(Relation.REMOVED, p_2, p_1)
    found = associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0)
    mirrored = Association(tuple(sorted((j, i) for i, j in found.pairs)), found.unmatched_2, found.unmatched_1)
    assert decided(Relation.MOVED, p_1, p_2, found) == decided(Relation.FORMER, p_2, p_1, mirrored)


@given(homes)
def test_nothing_changed_is_no_change(home):
    below = Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU) if home else NO_CANDIDATE
    assert ask(Relation.APPEARED, home, home) == ask(Relation.REMOVED, home, home) == NO_CANDIDATE
    assert ask(Relation.MOVED, home, home) == ask(Relation.FORMER, home, home) == below


@pytest.mark.parametrize("relation", STATIC)
def test_an_empty_home_abstains(relation):
    assert ask(relation, [], []) == NO_CANDIDATE


@given(homes.filter(lambda home: len(home) > 0))
def test_if_the_other_visit_is_empty_one_candidate_is_answered_and_several_are_not_ranked(home):
    expected = Answer(*home[0]) if len(home) == 1 else Abstention(AbstentionReason.NO_COUNTERPART)
    for relation in (Relation.MOVED, Relation.APPEARED, Relation.FORMER, Relation.REMOVED):
        p_1, p_2 = (home, []) if relation in PAST else ([], home)
        assert ask(relation, p_1, p_2) == expected and isinstance(ask(relation, p_2, p_1), Abstention)


def test_the_farthest_unmatched_instance_is_taken_and_matched_counterparts_count():
    assert ask(Relation.APPEARED, [(0.0, 0.0)], [(0.1, 0.0), (2.0, 0.0), (5.0, 0.0)]) == Answer(5.0, 0.0)
    p_1 = [(0.0, 0.0), (10.0, 0.0)]
    assert ask(Relation.APPEARED, p_1, [*p_1, (12.0, 0.0), (3.0, 0.0)]) == Answer(3.0, 0.0)
    tied = Association((), (), (0, 1, 2))
    for spots in itertools.permutations([(3.0, 0.0), (0.0, 3.0), (-3.0, 0.0)]):
        assert decided(Relation.MOVED, [(0.0, 0.0)], spots, tied) == Answer(-3.0, 0.0), "then the smallest x, then z"


@pytest.mark.parametrize("displacement, moved", [(TAU, True), (float(np.nextafter(TAU, 0.0)), False)])
def test_tau_counts_as_moved_and_not_as_stable(displacement, moved):
    ends, one = ([(0.0, 0.0)], [(displacement, 0.0)]), Association(((0, 0),), (), ())
    below, above = (Abstention(AbstentionReason(f"displacement_{side}_tau")) for side in ("below", "above"))
    assert decided(Relation.MOVED, *ends, one) == (Answer(displacement, 0.0) if moved else below)
    assert decided(Relation.FORMER, *ends, one) == (Answer(0.0, 0.0) if moved else below)
    assert decided(Relation.STABLE, *ends, one) == (above if moved else Answer(displacement, 0.0))


@pytest.mark.parametrize("metres", [(1.0, 0.8, 0.9), (0.8, 1.0, 0.9), (0.8, 0.9, 1.0)])
def test_the_largest_displacement_has_moved_and_the_smallest_is_stable(metres):
    p_1 = [(5.0 * k, 0.0) for k in range(3)]
    p_2 = [(x, moved) for (x, _), moved in zip(p_1, metres, strict=True)]
    pairs = Association(((0, 0), (1, 1), (2, 2)), (), ())
    assert decided(Relation.MOVED, p_1, p_2, pairs) == Answer(*p_2[metres.index(1.0)])
    assert decided(Relation.FORMER, p_1, p_2, pairs) == Answer(*p_1[metres.index(1.0)])
    nearer = [(x, z - 0.3) for x, z in p_2]
    assert decided(Relation.STABLE, p_1, nearer, pairs) == Answer(*nearer[metres.index(0.8)])


def test_of_equal_displacements_the_pair_of_smallest_positions_is_taken():
    p_1, p_2 = [(5.0, 0.0), (0.0, 7.0)], [(4.0, 0.0), (1.0, 7.0)]
    both = Association(((0, 0), (1, 1)), (), ())
    assert decided(Relation.MOVED, p_1, p_2, both) == Answer(1.0, 7.0)
    assert decided(Relation.FORMER, p_1, p_2, both) == Answer(0.0, 7.0)
    assert decided(Relation.STABLE, p_1, p_1, both) == Answer(0.0, 7.0)


def test_moved_and_former_fall_back_on_pairs_and_appeared_and_removed_do_not():
    assert ask(Relation.MOVED, [(0.0, 0.0)], [(1.0, 0.0), (9.0, 0.0)]) == Answer(9.0, 0.0), "an unmatched one comes first"
    assert ask(Relation.FORMER, [(0.0, 0.0)], [(1.0, 0.0)]) == Answer(0.0, 0.0)
    assert ask(Relation.APPEARED, [(0.0, 0.0)], [(1.0, 0.0)]) == ask(Relation.REMOVED, [(0.0, 0.0)], [(1.0, 0.0)]) == NO_CANDIDATE


# MOVING -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spread, moves", [(SPREAD, False), (SPREAD + 1e-6, True)])
def test_the_spread_must_exceed_its_threshold(spread, moves):
    answer = decide_by_spread([[(0.0, 0.0), (spread, 0.0)]], SPREAD)
    assert answer == (Answer(spread, 0.0) if moves else Abstention(AbstentionReason.NO_MOTION))


def test_moving_takes_the_largest_spread_and_its_last_point():
    still, slow, fast = [(0.0, 0.0)] * 3, [(1.0, 0.0), (1.5, 0.0)], [(5.0, 0.0), (5.0, 2.0), (5.0, 1.0)]
    assert decide_by_spread([still, slow, fast, []], SPREAD) == Answer(5.0, 1.0)
    assert decide_by_spread([[], []], SPREAD) == NO_CANDIDATE
    assert spread_m([]) == spread_m([(3.0, 4.0)]) == 0.0 and spread_m([(0.0, 0.0), (3.0, 4.0), (3.0, 0.0)]) == 5.0
    tied = [[(0.0, 0.0), (-1.0, 0.0)], [(0.0, 8.0), (-1.0, 8.0)], [(0.5, -9.0), (-0.5, -9.0)]]
    for order in itertools.permutations(tied):
        assert decide_by_spread(order, SPREAD) == Answer(-1.0, 0.0)


def test_under_perception_the_unmatched_cluster_that_was_seen_latest_is_answered():
    tracks = [[(9.0, 9.0), (0.0, 1.0)], [(-9.0, 0.0), (0.0, 2.0)], [(-8.0, 0.0), (1.0, 0.0)], [(-5.0, -5.0)]]
    for order in itertools.permutations(range(3)):
        some, every = [tracks[k] for k in (*order, 3)], Association((), (), (0, 1, 2, 3))
        assert decide_by_last_sighting(some, [7, 7, 7, 6], every) == Answer(0.0, 1.0)
        assert decide_by_last_sighting(some, [7, 7, 7, 8], every) == Answer(-5.0, -5.0)
        assert decide_by_last_sighting(some, [7, 7, 7, 8], Association(((0, 3),), (), (0, 1, 2))) == Answer(0.0, 1.0)
    assert decide_by_last_sighting(tracks, [0] * 4, Association((), (), ())) == NO_CANDIDATE


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


def asked(relation: Relation, first, second, noun: int = 0, settings: Settings = CONFIG):
    maps = ObjectMap.of(first), ObjectMap.of(second)
    grounded = (ground(m.f, one_hot(noun), settings.grounding.similarity_margin) for m in maps)
    return answer_two_visits(relation, *maps, *grounded, settings)


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
    settings = constants(0.2, gate_m)
    answer, evidence = asked(relation, first, second, settings=settings)
    shuffled = [random.sample(visit, len(visit)) for visit in (first, second)]
    assert asked(relation, *shuffled, settings=settings)[0] == answer
    for i, j in evidence.pairs:
        assert i in evidence.grounded_1 and j in evidence.grounded_2
        unlike = 1 - first[i].feature @ second[j].feature
        assert np.linalg.norm(first[i].position - second[j].position) + 2.0 * unlike < gate_m + 1e-9


def test_features_tell_apart_instances_that_places_confuse():
    slanted = (0.8, 0.6, 0.0)
    first = [cluster(0.0, 0.0), cluster(0.4, 0.0, slanted)]
    second = [cluster(0.35, 0.0), cluster(0.05, 0.0, slanted)]
    assert asked(Relation.STABLE, first, second, settings=constants(0.5))[1].pairs == ((0, 0), (1, 1))
    assert asked(Relation.STABLE, first, second, settings=constants(0.5, feature_scale_m=1e-9))[1].pairs == ((0, 1), (1, 0))


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
