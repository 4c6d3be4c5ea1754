"""The answers of the joint agent on true objects of a real scene in which a chair was moved, whole and with parts taken away."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.interface import Abstention, Action, Query, Relation, Visit
from ovman.agents.joint.agent import JointAgent, predict, predict_without_depth, predict_without_identity, predict_without_objects
from ovman.agents.joint.segments import Segments, read_segments, weigh_tours, write_segments
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import nothing_detected
from ovman.settings import Need
from tests.agents.moved_chair import off
from tests.arms import CONFIG

RADIUS_M = CONFIG.success.radius_m
NEW, OLD = (Relation.MOVED, Relation.APPEARED), (Relation.FORMER, Relation.REMOVED)


def told(home, *tours) -> SimpleNamespace:
    """Return the inputs that the evaluator gives to a prediction and to an agent, about these tours."""
    first, second = tours or (home.before, home.after)
    visits = {"first": first.visit, "second": second.visit}
    segments = weigh_tours(first.visit, second.visit, first.detected, second.detected, CONFIG.joint)
    return SimpleNamespace(
        settings=CONFIG,
        pilot=Pilot(CONFIG.primitives, np.random.default_rng(0)),
        made=lambda need, read: {Need.SEGMENTS: {tuple(str(visit.content) for visit in visits.values()): segments}}[need],
        tour=visits.__getitem__,
        noun=lambda phrase: home.chair if phrase == "chair" else np.zeros(len(home.chair)),
    )


@pytest.fixture(scope="module")
def context(home):
    return told(home)


@pytest.mark.parametrize("relation", [*NEW, *OLD])
def test_the_chair_is_where_it_is_and_was_where_it_was(home, context, relation):
    """Features that are the instance make every part enough on its own, and without a noun the change alone answers."""
    expected = home.new if relation in NEW else home.old
    assert off(predict(Query("Chair", relation), context)[0], expected) <= RADIUS_M
    if relation in (Relation.APPEARED, Relation.REMOVED):
        for without in (predict_without_depth, predict_without_identity, predict_without_objects):
            assert off(without(Query("Chair", relation), context)[0], expected) <= RADIUS_M
        assert off(predict(Query("", relation), context)[0], expected) <= RADIUS_M


def test_of_swapped_tours_the_places_are_swapped_and_what_is_stable_is_neither(home, context):
    swapped = told(home, home.after, home.before)
    for relation, expected in ((Relation.MOVED, home.old), (Relation.FORMER, home.new)):
        assert off(predict(Query("Chair", relation), swapped)[0], expected) <= RADIUS_M
    stable, _ = predict(Query("", Relation.STABLE), context)
    assert min(off(stable, where) for where in (home.new, home.old)) > 0.5


def test_identity_tells_moved_from_appeared_and_former_from_removed(home, context):
    # The chair that came is the one that went: as something that only came it is less likely than with no such likeness.
    for relations, at in ((NEW, home.new), (OLD, home.old)):
        moved, alone = (predict(Query("Chair", relation), context)[0] for relation in relations)
        assert off(moved, at) <= RADIUS_M and moved.confidence > alone.confidence


@pytest.mark.parametrize("blind", ["first", "second"])
def test_a_tour_that_showed_nothing_raises_nothing(home, blind):
    tours = {"first": home.before, "second": home.after}
    tours[blind] = replace(tours[blind], visit=Visit((), np.zeros((0, 2))), detected=nothing_detected())
    dark = told(home, *tours.values())
    for relation in Relation:
        found, _ = predict(Query("Chair", relation), dark)
        assert isinstance(found, Abstention) == (blind == ("first" if relation.past else "second")), relation


def test_it_drives_there_without_images_and_looks_for_movers_alone(home, context):
    drives = JointAgent(context)
    drives.familiarise(home.before.visit)
    drives.revisit(home.after.visit)
    drives.ask(Query("Chair", Relation.MOVING))
    assert drives.looks
    drives.ask(Query("Chair", Relation.MOVED))
    assert not drives.looks
    far = max(home.after.visit.reachable, key=lambda cell: math.dist(cell, home.new))
    start = home.after.visit.observations[0]
    first = replace(start, rgb=None, depth=None, pose=replace(start.pose, x=float(far[0]), z=float(far[1]), yaw_deg=0.0))
    assert drives.act(first) in (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT)


def test_segments_are_the_same_when_they_are_read_again(home, tmp_path):
    weighed = weigh_tours(home.before.visit, home.after.visit, home.before.detected, home.after.detected, CONFIG.joint)
    write_segments(tmp_path / "segments.npz", {("a", "b"): weighed, ("b", "a"): weighed[::-1]})
    again = read_segments(tmp_path / "segments.npz")
    assert list(again) == [("a", "b"), ("b", "a")]
    for was, now in ((weighed, again["a", "b"]), (weighed[::-1], again["b", "a"])):
        for one, other in zip(was, now, strict=True):
            assert all(np.array_equal(getattr(one, name), getattr(other, name)) for name in Segments.__slots__)
            assert len(one)
    write_segments(tmp_path / "none.npz", {})
    assert read_segments(tmp_path / "none.npz") == {}
