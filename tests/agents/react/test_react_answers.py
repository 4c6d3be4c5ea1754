"""What REACT's output answers by relation: by hand, and on true objects of a real scene in which a chair was moved."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ovman.agents.interface import (
    Abstention,
    AbstentionReason,
    Action,
    Answer,
    CameraPose,
    Evidence,
    Observation,
    Query,
    Relation,
)
from ovman.agents.pilot import Pilot
from ovman.agents.react.agent import ReactAgent, answer, decide_relation, predict_two_visits
from ovman.agents.reference.association import Association
from ovman.perception.clusters import Cluster
from ovman.perception.object_map import ObjectMap
from ovman.workflow.parameter import stage_settings
from tests.agents.moved_chair import home as made
from tests.arms import CONFIG

SETTINGS = stage_settings(CONFIG, "predictions", "react_two_visits")
TAU_M, RADIUS_M = SETTINGS.admissibility.tau_m, CONFIG.success.radius_m
CHAIR, LAMP = np.eye(3)[:2]


def objects(*places: tuple[float, float], last_seen: tuple[int, ...] = ()) -> ObjectMap:
    found = [np.array([place], float) for place in places]
    views = last_seen or tuple(range(len(found)))
    return ObjectMap.of([Cluster(at[0], CHAIR, at, np.array([view])) for at, view in zip(found, views, strict=True)])


FIRST, SECOND = objects((0, 0), (5, 0), (0, 6)), objects((0, 0.2), (9, 0), (3, 3), last_seen=(7, 5, 6))
FOUND = Association(((0, 0), (1, 1)), (2,), (2,))
"""The first stays, the second travels 4 m, the third is absent, and one is new."""


@pytest.mark.parametrize(
    ("relation", "place"),
    [
        (Relation.MOVED, (9, 0)),
        (Relation.FORMER, (5, 0)),
        (Relation.STABLE, (0, 0.2)),
        (Relation.APPEARED, (3, 3)),
        (Relation.REMOVED, (0, 6)),
        (Relation.MOVING, (3, 3)),
    ],
)
def test_each_relation_is_read_off_the_output(relation, place):
    assert decide_relation(relation, FIRST, SECOND, FOUND, SETTINGS) == Answer(*map(float, place))


def test_moving_is_what_was_seen_last_of_the_new_and_the_moved_but_not_of_the_unmoved():
    later = objects((0, 0.2), (9, 0), (3, 3), last_seen=(8, 7, 6))
    assert decide_relation(Relation.MOVING, FIRST, later, FOUND, SETTINGS) == Answer(9.0, 0.0)


def test_without_a_moved_one_a_new_or_an_absent_one_is_the_answer():
    still = Association(((0, 0),), (2,), (2,))
    assert decide_relation(Relation.MOVED, FIRST, SECOND, still, SETTINGS) == Answer(3.0, 3.0)
    assert decide_relation(Relation.FORMER, FIRST, SECOND, still, SETTINGS) == Answer(0.0, 6.0)


@pytest.mark.parametrize(
    ("relation", "found", "reason"),
    [
        (Relation.MOVED, Association(((0, 0),), (2,), ()), AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.FORMER, Association(((0, 0),), (), (2,)), AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.MOVED, Association((), (2,), ()), AbstentionReason.NO_CANDIDATE),
        (Relation.STABLE, Association(((1, 1),), (2,), (2,)), AbstentionReason.DISPLACEMENT_ABOVE_TAU),
        (Relation.APPEARED, Association(((0, 0),), (2,), ()), AbstentionReason.NO_CANDIDATE),
        (Relation.REMOVED, Association(((0, 0),), (), (2,)), AbstentionReason.NO_CANDIDATE),
        (Relation.MOVING, Association(((0, 0),), (2,), ()), AbstentionReason.NO_CANDIDATE),
    ],
)
def test_what_the_output_does_not_have_is_an_abstention(relation, found, reason):
    assert decide_relation(relation, FIRST, SECOND, found, SETTINGS) == Abstention(reason)


@pytest.mark.parametrize("gone_m", [TAU_M - 0.01, TAU_M])
def test_a_matched_one_has_moved_from_tau_on(gone_m):
    first, second, found = objects((0, 0)), objects((gone_m, 0)), Association(((0, 0),), (), ())
    moved = gone_m >= TAU_M
    assert isinstance(decide_relation(Relation.MOVED, first, second, found, SETTINGS), Answer) is moved
    assert isinstance(decide_relation(Relation.STABLE, first, second, found, SETTINGS), Answer) is not moved
    assert isinstance(decide_relation(Relation.MOVING, first, second, found, SETTINGS), Answer) is moved


def embedding(phrase: str) -> np.ndarray:
    return {"chair": CHAIR, "floor lamp": LAMP}.get(phrase, np.eye(3)[2])


def test_the_evidence_is_what_the_noun_means_and_what_was_taken_for_the_same():
    first, second = objects((0, 0), (5, 0)), objects((0, 0.2))
    outcome, evidence = answer(Relation.REMOVED, first, second, (0, 1), (0,), embedding=embedding, settings=SETTINGS)
    assert (outcome, evidence) == (Answer(5.0, 0.0), Evidence((0, 1), (0,), ((0, 0),)))
    other_end = answer(Relation.REMOVED, first, second, (1,), (0,), embedding=embedding, settings=SETTINGS)
    assert other_end == (outcome, evidence), "a pair is meant if one of its ends is"
    nothing = answer(Relation.REMOVED, first, second, (), (), embedding=embedding, settings=SETTINGS)
    assert nothing == (Abstention(AbstentionReason.NOTHING_GROUNDED), Evidence((), ()))


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return made(tmp_path_factory)


class Context:
    """The true objects of a home, and its chair as the noun; every other name means nothing."""

    settings, privileged_grounding = SETTINGS, False

    def __init__(self, home, first="before", second="after"):
        self._tours, self._chair = {"first": getattr(home, first), "second": getattr(home, second)}, home.chair

    def map(self, which):
        return ObjectMap.of(self._tours[which].clusters())

    def noun(self, phrase):
        return self._chair if phrase == "chair" else np.zeros_like(self._chair)


def off(found: Answer | Abstention, at: tuple[float, float]) -> float:
    return math.dist((found.x, found.z), at) if isinstance(found, Answer) else math.inf


def test_in_a_real_scene_a_moved_chair_is_found_at_both_places(home):
    for relation, place in ((Relation.MOVED, home.new), (Relation.FORMER, home.old)):
        outcome, evidence = predict_two_visits(Query("Chair", relation), Context(home))
        assert off(outcome, place) < RADIUS_M and len(evidence.pairs) == 1


def test_in_a_real_scene_that_is_as_it_was_the_chair_is_stable_and_nothing_else(home):
    as_it_was = Context(home, "before", "before")
    assert off(predict_two_visits(Query("Chair", Relation.STABLE), as_it_was)[0], home.old) < RADIUS_M
    for relation in set(Relation) - {Relation.STABLE}:
        assert isinstance(predict_two_visits(Query("Chair", relation), as_it_was)[0], Abstention)


def test_the_embodied_arm_drives_to_the_static_answer(home):
    went = []

    class Recording(Pilot):
        def act(self, observation, goal):
            went.append(goal)
            return Action.STOP

    class Driving(Context):
        pilot = Recording(CONFIG.primitives, np.random.default_rng(0))

        def mapper(self, visit):
            return next(one.clusters() for one in self._tours.values() if one.visit is visit)

    driver = ReactAgent(Driving(home))
    driver.familiarise(home.before.visit)
    driver.revisit(home.after.visit)
    driver.ask(Query("Chair", Relation.MOVED))
    assert driver.act(Observation(None, None, CameraPose(0.0, 1.5, 0.0, 0.0, 0.0), 90.0)) is Action.STOP
    expected, _ = predict_two_visits(Query("Chair", Relation.MOVED), Context(home))
    assert went == [(expected.x, expected.z)]
