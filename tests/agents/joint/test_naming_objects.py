"""Names and objects: probabilities, shrinkage, and what is one object."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Relation
from ovman.agents.joint.decision import (
    Nouns,
    Objects,
    compare_objects,
    compare_places,
    decide,
    decide_moving,
    group_objects,
    pick_best,
)
from ovman.agents.joint.segments import Segments
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from tests.arms import CONFIG

CONSTANTS = CONFIG.joint
PHRASES = list(dict.fromkeys(noun(category) for category in SYNONYMS))
FEATURES = np.eye(len(PHRASES) + 1)
CHAIR = PHRASES.index("chair")


def embedding(phrase: str) -> np.ndarray:
    return FEATURES[PHRASES.index(phrase)] if phrase in PHRASES else FEATURES[-1]


NOUNS = Nouns(embedding, CONSTANTS)


def seen(places, features=None, views=None, changed=0.0, moving=-3.0) -> Segments:
    places = np.array([(x, 0.5, z) for x, z in places], float).reshape(-1, 3)
    count = len(places)
    return Segments(
        view=np.arange(count) if views is None else np.array(views),
        place=places,
        low=places,
        high=places,
        colour=np.zeros((count, 3)),
        cells=np.full(count, 20),
        feature=FEATURES[[CHAIR] * count] if features is None else np.array(features),
        named=np.ones(count, bool),
        changed=np.full(count, changed),
        moving=np.full(count, moving),
    )


def objects(*places, colour=(0.0, 0.0, 0.0), feature=None, changed=3.0) -> Objects:
    """Objects one metre high that are named and changed."""
    count = len(places)
    return Objects(
        place=np.array([(x, 0.5, z) for x, z in places], float).reshape(-1, 3),
        top=np.ones(count),
        colour=np.tile(colour, (count, 1)),
        feature=np.tile(FEATURES[CHAIR], (count, 1)) if feature is None else np.array(feature),
        named=np.zeros(count),
        changed=np.broadcast_to(changed, count),
    )


def test_probabilities_of_the_vocabulary_come_to_one_whatever_is_shown():
    rng = np.random.default_rng(1)
    shown = rng.normal(size=(5, len(FEATURES)))
    shown /= np.linalg.norm(shown, axis=1, keepdims=True)
    every = np.exp([NOUNS.log_probability(shown, phrase) for phrase in PHRASES]).sum(axis=0)
    assert every == pytest.approx(1.0)
    unlike = np.stack([np.zeros(len(FEATURES)), FEATURES[-1]])
    assert NOUNS.log_probability(unlike, "chair") == pytest.approx(NOUNS.chance), "no feature, and one that resembles nothing"
    other = NOUNS.log_probability(FEATURES[:1], PHRASES[1])
    assert other == pytest.approx(np.log(CONSTANTS.astray / len(PHRASES))), "a name is never ruled out"


def test_another_phrase_means_the_categories_that_it_resembles():
    assert NOUNS.log_probability(FEATURES[:1], "contraption") == pytest.approx(NOUNS.chance), "it resembles all synonyms alike"
    resembling = Nouns(lambda phrase: FEATURES[CHAIR] if phrase == "contraption" else embedding(phrase), CONSTANTS)
    chair, other = resembling.log_probability(FEATURES[[CHAIR, CHAIR + 1]], "contraption")
    assert chair > np.log(0.8) and other < NOUNS.chance


def test_more_views_are_believed_more():
    named = [group_objects(seen([(0, 0)] * count), "chair", NOUNS, CONSTANTS).named for count in (1, 2, 8)]
    assert [len(one) for one in named] == [1, 1, 1] and NOUNS.chance < named[0] < named[1] < named[2] < 0


def test_one_place_and_one_look_make_one_object_and_two_of_either_make_two():
    def count(places, features=None):
        return len(group_objects(seen(places, features), "chair", NOUNS, CONSTANTS))

    assert count([(0, 0), (0.1, 0)]) == 1 and count([(0, 0), (2 * CONSTANTS.radius_m, 0)]) == 2
    assert count([(0, 0), (0, 0)], [FEATURES[CHAIR], -FEATURES[CHAIR]]) == 2
    assert count([]) == 0


def test_objects_do_not_depend_on_the_order_of_the_segments():
    rng = np.random.default_rng(2)
    many = seen(rng.uniform(0, 3, (20, 2)))
    order = rng.permutation(20)
    other = replace(many, **{name: getattr(many, name)[order] for name in Segments.__slots__})
    one, two = (group_objects(segments, "chair", NOUNS, CONSTANTS) for segments in (many, other))
    assert np.allclose(one.place[np.lexsort(one.place.T)], two.place[np.lexsort(two.place.T)])


def test_a_track_follows_views_no_faster_than_a_mover_and_ends_where_it_was_seen_last():
    walk = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.5, 0.0)]
    away = seen([*walk, (6.0, 0.0)], views=[0, 1, 2, 3, 4], moving=3.0)
    assert place(decide_moving(away, "chair", NOUNS, CONSTANTS)) == (1.5, 0.0)


def test_what_came_before_the_visit_and_stands_still_does_not_move():
    standing, mover = [(0.0, 0.0)] * 4, (6.0, 0.0)
    came = seen([*standing, mover], views=[0, 1, 2, 3, 4], moving=[-3.0] * 4 + [1.0], changed=[3.0] * 4 + [0.0])
    assert place(decide_moving(came, "chair", NOUNS, CONSTANTS)) == mover


def test_one_instance_stands_at_two_places_in_two_lights_and_another_differs_in_hue_height_or_crop():
    standing, red, plain = (0.0, 0.0), np.log([2.0, 1.0, 1.0]), np.zeros(3)
    first, second = objects(standing, (3, 0), changed=[-3.0, 3.0]), objects(standing, (6, 0), colour=red, changed=[-3.0, 3.0])
    odds = compare_objects(first, second, CONSTANTS)[1, 1]
    assert odds > 2 and compare_objects(second, first, CONSTANTS)[1, 1] == pytest.approx(odds)
    others = (
        replace(second, colour=np.array([red, plain])),
        replace(second, top=second.top + np.array([0.0, 0.3])),
        replace(second, feature=FEATURES[[CHAIR, CHAIR + 1]]),
    )
    assert all(compare_objects(first, other, CONSTANTS)[1, 1] < odds - 2 for other in others)
    assert compare_objects(first, objects(), CONSTANTS).shape == (2, 0)


def test_what_stands_where_another_thing_stood_has_changed():
    places, same, swapped = [(0, 0), (3, 0)], FEATURES[[CHAIR, CHAIR]], FEATURES[[CHAIR, CHAIR + 1]]
    first, second = seen(places, features=same), seen(places, features=swapped)
    odds = compare_places(second, first, CONSTANTS)
    assert odds[0] < -2 and odds[1] > 2
    unnamed = replace(second, named=np.array([True, False]))
    assert compare_places(unnamed, first, CONSTANTS)[1] == 0
    assert (compare_places(first, seen([]), CONSTANTS) == -CONSTANTS.unlike).all()


def test_what_moved_is_not_what_came_and_each_vacated_place_is_of_one_thing():
    first, second = objects((0, 0), (3, 0)), objects((6, 0), (9, 0))
    for same, moved, came in (([[2, 1], [-4, -4]], 6, 9), ([[1, 2], [-4, -4]], 9, 6), ([[-4, -4], [3, 1]], 6, 9)):
        found = [place(decide(relation, first, second, np.array(same, float), CONSTANTS)) for relation in (
            Relation.MOVED, Relation.APPEARED)]  # fmt: skip
        assert found == [(moved, 0.0), (came, 0.0)]
        vacated = [place(decide(relation, second, first, np.array(same, float).T, CONSTANTS)) for relation in (
            Relation.FORMER, Relation.REMOVED)]  # fmt: skip
        assert vacated == [(moved, 0.0), (came, 0.0)]


def test_confidence_is_the_share_of_the_probability_that_lies_at_the_place():
    def confidence(*scores, least=0.0):
        places = np.array([(0.0, 0.5, 0.0), (0.1, 0.5, 0.0), (5.0, 0.5, 0.0)])[: len(scores)]
        return pick_best(places, np.log(np.array(scores)), CONSTANTS.model_copy(update={"least_confidence": least}))

    assert confidence(0.3).confidence == 1.0
    assert confidence(0.3, 0.1, 0.4) == Answer(5.0, 0.0, 0.5) and confidence(0.5, 0.1, 0.4) == Answer(0.0, 0.0, 0.6)
    assert confidence(0.5, 0.1, 0.4, least=0.61) == Abstention(AbstentionReason.UNSURE)


def place(outcome):
    return outcome.x, outcome.z
