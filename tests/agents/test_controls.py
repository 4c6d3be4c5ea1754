"""Controls that compare tours: on pictures that are made up, and on tours of a real scene in which one thing was moved."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.controls import (
    compare_colours,
    compare_depth,
    depth_difference,
    find_difference,
    look_up,
    predict_depth_difference,
    predict_pixel_difference,
    sample_tour,
)
from ovman.agents.interface import Abstention, AbstentionReason, Action, CameraPose, Observation, Query, Relation, Visit
from tests.agents.moved_chair import off
from tests.arms import CONFIG

CONSTANTS, RADIUS_M = CONFIG.controls, CONFIG.success.radius_m
EVERY_PX, HIDDEN_M = CONSTANTS.every_px, CONSTANTS.changed_m
CONTROLS = {"depth": compare_depth, "pixel": compare_colours}
PAST, PRESENT = True, False
SIDE, FAR_M, NEAR_M, GREY, RED = 60, 4.0, 2.0, (128, 128, 128), (255, 0, 0)
AHEAD = CameraPose(0.0, 1.5, 0.0, 0.0, 0.0)
REACHABLE = np.array([[0.0, 0.0]])


def frame(*boxes: tuple[slice, slice], pose: CameraPose = AHEAD) -> Observation:
    """A grey wall at FAR_M, with red boxes at NEAR_M before it."""
    rgb, depth = np.full((SIDE, SIDE, 3), GREY, np.uint8), np.full((SIDE, SIDE), FAR_M, np.float32)
    for box in boxes:
        rgb[box], depth[box] = RED, NEAR_M
    return Observation(rgb, depth, pose, 90.0)


def tour(*frames: Observation) -> Visit:
    return Visit(frames, REACHABLE)


LEFT, RIGHT = (slice(10, 40), slice(5, 20)), (slice(20, 30), slice(40, 50))
"""Rows and columns of a larger and of a smaller box."""


def place(box: tuple[slice, slice]) -> tuple[float, float]:
    """Where a box stands on the floor plane: columns are NEAR_M / (SIDE / 2) wide there."""
    return ((box[1].start + box[1].stop) / 2 - SIDE / 2) * NEAR_M / (SIDE / 2), NEAR_M


UPPER, LOWER, MIDDLE = (slice(2, 12), slice(0, 12)), (slice(45, 55), slice(0, 12)), (slice(20, 35), slice(40, 52))


@pytest.mark.parametrize(
    ("past", "first", "second", "at", "differs"),
    [
        (PAST, (RIGHT,), (), RIGHT, "depth pixel"),
        (PRESENT, (), (RIGHT,), RIGHT, "depth pixel"),
        (PAST, (LEFT,), (RIGHT,), LEFT, "depth"),
        (PRESENT, (LEFT,), (RIGHT,), RIGHT, "depth"),
        (PRESENT, (), (UPPER, LOWER, MIDDLE), MIDDLE, "depth"),
    ],
)
def test_the_largest_connected_part_that_one_tour_alone_shows_is_found(past, first, second, at, differs):
    for name in differs.split():
        found = find_difference(past, tour(frame(*first)), tour(frame(*second)), CONTROLS[name], CONSTANTS)
        assert (found.x, found.z) == pytest.approx(place(at), abs=0.1)


def test_colours_do_not_tell_what_came_from_what_went():
    """The larger patch of other colours is where the box has left a wall."""
    found = find_difference(PRESENT, tour(frame(LEFT)), tour(frame(RIGHT)), CONTROLS["pixel"], CONSTANTS)
    assert found.z == pytest.approx(FAR_M) and found.x < 0


@pytest.mark.parametrize("differs", CONTROLS.values(), ids=CONTROLS)
def test_without_a_difference_or_without_a_tour_it_abstains(differs):
    nothing = Abstention(AbstentionReason.NO_CANDIDATE)
    assert find_difference(PRESENT, tour(frame(LEFT)), tour(frame(LEFT)), differs, CONSTANTS) == nothing
    for first, second in ((tour(), tour(frame(LEFT))), (tour(frame(LEFT)), tour()), (tour(), tour())):
        for past in (PAST, PRESENT):
            assert find_difference(past, first, second, differs, CONSTANTS) == nothing
    unknown = tour(replace(frame(), depth=np.zeros((SIDE, SIDE), np.float32)))
    for first, second in ((unknown, tour(frame(LEFT))), (tour(frame(LEFT)), unknown)):
        assert find_difference(PRESENT, first, second, CONTROLS["depth"], CONSTANTS) == nothing


def test_a_tour_without_pictures_is_one_line():
    with pytest.raises(ValueError, match=r"^a control compares pictures; write needs: \[tours\] in its entry$"):
        find_difference(PRESENT, tour(Observation(None, None, AHEAD, 90.0)), tour(), CONTROLS["depth"], CONSTANTS)


def test_places_are_found_in_another_camera_and_what_stands_before_them_hides_them():
    aside = CameraPose(0.5, 1.5, 0.0, 0.0, 0.0)
    here, other = (sample_tour(tour(one), EVERY_PX) for one in (frame(), frame(LEFT, pose=aside)))
    (shown,) = look_up(here[0], other, EVERY_PX, HIDDEN_M)
    # A step aside of 0.5 m is 0.5 * 30 / 4 pixels of the wall.
    moved = 0.5 * (SIDE / 2) / FAR_M
    columns = np.arange(EVERY_PX // 2, SIDE, EVERY_PX) + 0.5 - moved
    inside = np.zeros(here[0].depth.size, bool)
    inside[shown.which] = True
    assert (inside.reshape(here[0].depth.shape) == (columns >= 0)[None, :]).all()
    assert np.isfinite(shown.depth).all() and np.allclose(shown.away, FAR_M)
    assert (shown.own == here[0].rgb.reshape(-1, 3)[inside]).all()
    hidden, (darkest, lightest) = shown.depth < FAR_M, shown.colours
    assert hidden.any() and np.isnan(darkest[hidden]).all() and np.isnan(CONTROLS["depth"](shown, CONSTANTS)[hidden]).all()
    assert np.isfinite(lightest[~hidden]).all() and (CONTROLS["depth"](shown, CONSTANTS)[~hidden] < 0).all()
    elsewhere = sample_tour(tour(frame(pose=replace(AHEAD, yaw_deg=180.0))), EVERY_PX)
    assert list(look_up(here[0], elsewhere, EVERY_PX, HIDDEN_M)) == []


def test_the_frame_of_the_same_pose_is_asked_alone_pixel_by_pixel():
    aside = CameraPose(0.5, 1.5, 0.0, 0.0, 0.0)
    here, tours = sample_tour(tour(frame()), EVERY_PX)[0], sample_tour(tour(frame(pose=aside), frame(LEFT)), EVERY_PX)
    (shown,) = look_up(here, tours, EVERY_PX, HIDDEN_M)
    assert (shown.depth == tours[1].depth.ravel()).all() and len(shown.depth) == here.depth.size
    assert all((bound == tours[1].rgb.reshape(-1, 3)).all() for bound in shown.colours)
    assert (shown.own == here.rgb.reshape(-1, 3)).all() and (shown.away == here.depth.ravel()).all()
    assert len(list(look_up(here, tours[:1] * 3, EVERY_PX, HIDDEN_M))) == 3


@pytest.mark.parametrize("control", [predict_depth_difference, predict_pixel_difference])
def test_neither_the_noun_nor_the_relation_is_read_but_whether_the_place_is_past(control):
    tours = {"first": tour(frame(LEFT)), "second": tour(frame(RIGHT))}
    context = SimpleNamespace(settings=CONFIG, tour=tours.__getitem__)
    by_tense = {}
    for relation in Relation:
        for category in ("Chair", "Vase", ""):
            by_tense.setdefault(relation.past, set()).add(control(Query(category, relation), context)[0])
    assert {past: len(answers) for past, answers in by_tense.items()} == {PAST: 1, PRESENT: 1}


def test_it_drives_to_what_it_predicts_and_abstains_where_it_finds_nothing(wheels):
    def driven(first, second):
        agent = depth_difference(SimpleNamespace(pilot=wheels, settings=CONFIG, answered=None))
        agent.familiarise(first)
        agent.revisit(second)
        agent.ask(Query("Chair", Relation.APPEARED))
        return agent.act(Observation(None, None, AHEAD, 90.0))

    assert driven(tour(frame()), tour(frame(RIGHT))) is Action.STOP
    assert wheels.goals == [pytest.approx(place(RIGHT), abs=0.1)]
    assert driven(tour(frame()), tour(frame())) is Action.ABSTAIN


def test_in_a_real_scene_depth_finds_both_places_of_a_chair_and_colours_where_it_is(home):
    before, after = home.before.visit, home.after.visit
    assert off(find_difference(PAST, before, after, CONTROLS["depth"], CONSTANTS), home.old) <= RADIUS_M
    for compare in CONTROLS.values():
        assert off(find_difference(PRESENT, before, after, compare, CONSTANTS), home.new) <= RADIUS_M
        assert isinstance(find_difference(PAST, before, before, compare, CONSTANTS), Abstention)
