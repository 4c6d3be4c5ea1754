"""The answers of the joint agent on true objects of a real scene in which a chair was moved, whole and with parts taken away."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ovman.agents.interface import Abstention, Action, Query, Relation, Visit
from ovman.agents.joint.agent import JointAgent, predict, predict_without_depth, predict_without_identity, predict_without_objects
from ovman.agents.joint.decision import Nouns, answer
from ovman.agents.joint.segments import Segments, read_segments, weigh_tours, write_segments
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import nothing_detected
from ovman.settings import Need
from tests.agents.moved_chair import off
from tests.arms import CONFIG

SETTINGS = CONFIG
RADIUS_M = CONFIG.success.radius_m
NEW, OLD = (Relation.MOVED, Relation.APPEARED), (Relation.FORMER, Relation.REMOVED)


class Told:
    """What the evaluator gives to a prediction and to an agent."""

    settings = SETTINGS

    def __init__(self, home, swapped=False, blind=None):
        self._home = home
        self._tours = {"first": home.before, "second": home.after}
        if swapped:
            self._tours = {"first": home.after, "second": home.before}
        if blind:
            nothing = replace(self._tours[blind], visit=Visit((), np.zeros((0, 2))), detected=nothing_detected())
            self._tours[blind] = nothing
        self.pilot = Pilot(CONFIG.primitives, np.random.default_rng(0))
        tours = self._tours["first"], self._tours["second"]
        visits = [toured.visit for toured in tours]
        weighed = weigh_tours(*visits, *(toured.detected for toured in tours), SETTINGS.joint)
        self._weighed = {tuple(str(visit.content) for visit in visits): weighed}

    def made(self, need, read):
        assert need is Need.SEGMENTS
        return self._weighed

    def tour(self, which):
        return self._tours[which].visit

    def noun(self, phrase):
        return self._home.chair if phrase == "chair" else np.zeros(len(self._home.chair))


@pytest.mark.parametrize("relation", [*NEW, *OLD])
def test_the_chair_is_where_it_is_and_was_where_it_was(home, relation):
    expected = home.new if relation in NEW else home.old
    found, _ = predict(Query("Chair", relation), Told(home))
    assert off(found, expected) <= RADIUS_M
    swapped, _ = predict(Query("Chair", relation), Told(home, swapped=True))
    assert off(swapped, home.old if relation in NEW else home.new) <= RADIUS_M


def test_what_is_stable_is_neither_place(home):
    found, _ = predict(Query("Chair", Relation.STABLE), Told(home))
    assert min(off(found, where) for where in (home.new, home.old)) > 0.5


@pytest.mark.parametrize("without", [predict_without_depth, predict_without_identity, predict_without_objects])
def test_a_part_taken_away_still_answers_what_the_others_tell(home, without):
    # Features that are the instance make every part enough on its own.
    for relation, expected in ((Relation.APPEARED, home.new), (Relation.REMOVED, home.old)):
        found, _ = without(Query("Chair", relation), Told(home))
        assert off(found, expected) <= RADIUS_M


def test_identity_tells_moved_from_appeared_and_former_from_removed(home):
    # The chair that came is the one that went: as something that only came it is less likely than with no such likeness.
    constants = SETTINGS.joint.model_copy(update={"identity": 50.0})
    segments = weigh_tours(home.before.visit, home.after.visit, home.before.detected, home.after.detected, constants)
    nouns = Nouns(Told(home).noun, constants)
    moved, appeared = (answer(Query("Chair", relation), *segments, nouns, constants) for relation in NEW)
    assert off(moved, home.new) <= RADIUS_M and off(appeared, home.new) > RADIUS_M


def test_without_a_noun_the_change_alone_answers(home):
    found, _ = predict(Query("", Relation.FORMER), Told(home))
    assert off(found, home.old) <= RADIUS_M


@pytest.mark.parametrize("blind", ["first", "second"])
def test_a_tour_that_showed_nothing_raises_nothing(home, blind):
    told = Told(home, blind=blind)
    for relation in Relation:
        found, _ = predict(Query("Chair", relation), told)
        asked = "first" if relation.past else "second"
        assert isinstance(found, Abstention) == (blind == asked), relation


def test_it_drives_there_without_images_and_looks_for_movers_alone(home):
    drives = JointAgent(Told(home))
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
    weighed = weigh_tours(home.before.visit, home.after.visit, home.before.detected, home.after.detected, SETTINGS.joint)
    write_segments(tmp_path / "segments.npz", {("a", "b"): weighed, ("b", "a"): weighed[::-1]})
    again = read_segments(tmp_path / "segments.npz")
    assert list(again) == [("a", "b"), ("b", "a")]
    for was, now in ((weighed, again["a", "b"]), (weighed[::-1], again["b", "a"])):
        for one, other in zip(was, now, strict=True):
            assert all(np.array_equal(getattr(one, name), getattr(other, name)) for name in Segments.__slots__)
            assert len(one)
    write_segments(tmp_path / "none.npz", {})
    assert read_segments(tmp_path / "none.npz") == {}
