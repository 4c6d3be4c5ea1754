"""Pieces from depth, and the two controls that choose among them without the noun."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents import noun_blind
from ovman.agents.changes import compare_tours, find_largest_box, predict_largest_box
from ovman.agents.controls import LargestBox
from ovman.agents.interface import Abstention, AbstentionReason, Action, Answer, Observation, Query, Relation, Visit
from ovman.agents.joint.segments import weigh_tours
from ovman.settings import Need
from tests.agents.moved_chair import off
from tests.arms import CONFIG

RADIUS_M = CONFIG.success.radius_m
NOTHING = Abstention(AbstentionReason.NO_CANDIDATE)
NOW, THEN = (Relation.MOVED, Relation.APPEARED), (Relation.FORMER, Relation.REMOVED)


@pytest.fixture(scope="module")
def context(home):
    visits = {"first": home.before.visit, "second": home.after.visit}
    segments = weigh_tours(*visits.values(), home.before.detected, home.after.detected, CONFIG.joint)
    return SimpleNamespace(
        settings=CONFIG,
        tour=visits.__getitem__,
        spawn=np.array((0.0, 0.0)),
        made=lambda need, read: {Need.SEGMENTS: {tuple(str(visit.content) for visit in visits.values()): segments}}[need],
    )


def test_the_chair_is_a_piece_at_each_of_its_places_and_as_large_as_a_chair(home):
    gone, come = compare_tours(home.before.visit, home.after.visit, CONFIG.joint)
    for pieces, at in ((gone, home.old), (come, home.new)):
        chair = min(pieces, key=lambda piece: np.linalg.norm(piece.middle - at))
        assert np.linalg.norm(chair.middle - at) < 0.3
        assert chair.transient < 0.15
    # It stands free where it is now. The piece lacks its thin legs.
    assert 0.5 < chair.high[1] - chair.low[1] < 1.0 and chair.height_m < 0.6 and chair.reach_m < 0.9
    same = compare_tours(home.before.visit, home.before.visit, CONFIG.joint)
    assert same == ((), ())


@pytest.mark.parametrize("control", [predict_largest_box, noun_blind.predict])
def test_controls_find_the_one_change_and_no_noun_changes_their_answer(home, context, control):
    for relations, at in ((NOW, home.new), (THEN, home.old)):
        for relation in relations:
            found = {control(Query(category, relation), context)[0] for category in ("Chair", "Vase", "")}
            assert len(found) == 1 and off(found.pop(), at) <= RADIUS_M


def test_for_stable_the_classifier_names_what_stayed(home, context):
    found, _ = noun_blind.predict(Query("Chair", Relation.STABLE), context)
    assert isinstance(found, Answer) and min(off(found, at) for at in (home.new, home.old)) > 0.5


def test_without_a_change_or_a_tour_nothing_is_found(home):
    nothing = Visit((), home.before.visit.reachable)
    for first, second in ((home.before.visit, home.before.visit), (nothing, home.after.visit), (home.before.visit, nothing)):
        for relation in Relation:
            assert find_largest_box(Query("Chair", relation), first, second, CONFIG.joint) == NOTHING


def test_weights_fit_the_features(context):
    fitted = json.loads(noun_blind.WEIGHTS.read_text())
    assert fitted["features"] == list(noun_blind.FEATURES) and set(fitted["weights"]) == {*map(str, Relation)}
    found = noun_blind.list_candidates(Relation.MOVED, context)
    assert found.features.shape == (len(found.places), len(noun_blind.FEATURES)) and np.isfinite(found.features).all()


def test_the_agent_that_drives_goes_where_the_static_arm_points(home, wheels):
    agent = LargestBox(SimpleNamespace(pilot=wheels, settings=CONFIG, answered=None))
    agent.familiarise(home.before.visit)
    agent.revisit(home.after.visit)
    agent.ask(Query("Chair", Relation.MOVED))
    assert agent.act(Observation(None, None, None, 90.0)) is Action.STOP
    assert np.linalg.norm(np.subtract(wheels.goals[0], home.new)) <= RADIUS_M
