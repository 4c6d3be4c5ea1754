"""DynaMem: what a later view sees through is gone, hidden voxels stay, and the answers from the memory."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dynamem.agent import DynamemAgent, locate, map_noun, predict_current, predict_two_visits
from ovman.agents.dynamem.memory import Look, Memory, add, clear, look, look_at_tour, remember, remember_tours, remove_noise
from ovman.agents.interface import Abstention, AbstentionReason, Answer, Query, Relation, Visit
from ovman.perception.backprojection import Camera
from tests.agents.moved_chair import off
from tests.arms import CONFIG

CONSTANTS = CONFIG.dynamem
SIDE, WALL_M, BOX_M = 120, 2.4, 1.5
AHEAD = Camera((0.0, 1.5, 0.0), 0.0, 0.0, 90.0)
MUG, LAMP = np.eye(3)[0], np.eye(3)[1]
MIDDLE, CORNER = (slice(40, 70), slice(40, 70)), (slice(80, 110), slice(5, 35))
Box = tuple[slice, slice]


def frame(*boxes: tuple[Box, float, np.ndarray | None], wall_m: float = WALL_M, camera: Camera = AHEAD) -> Look:
    """A wall without detections, with boxes before it by place, depth and feature; a box without a feature is not detected."""
    depth, masks, features = np.full((SIDE, SIDE), wall_m, np.float32), [], []
    for box, depth_m, feature in boxes:
        depth[box] = depth_m
        if feature is not None:
            mask = np.zeros((SIDE, SIDE), bool)
            mask[box] = True
            masks.append(mask)
            features.append(feature)
    found = np.array(masks, bool).reshape(-1, SIDE, SIDE)
    return look(depth, camera, found, np.array(features).reshape(-1, 3), np.zeros((len(found), 3)), CONSTANTS)


def kinds(memory: Memory) -> set[int]:
    return set(memory.feature.argmax(axis=1).tolist()) if len(memory) else set()


def same(one: Memory, other: Memory) -> bool:
    return all(np.allclose(getattr(one, name), getattr(other, name)) for name in Memory.__slots__)


SEEN = frame((MIDDLE, BOX_M, MUG))
NEARER = BOX_M - 0.5
BACKWARDS = Camera((0.0, 1.5, 0.0), 180.0, 0.0, 90.0)


def standing(off_m: float) -> Camera:
    """A camera that is by `off_m` nearer to the box than points may be far."""
    return Camera((0.0, 1.5, BOX_M - CONSTANTS.farthest_m + off_m), 0.0, 0.0, 90.0)


def test_points_are_where_the_pixels_show_them_and_have_their_detections_feature():
    memory = remember((SEEN,), CONSTANTS)
    assert len(memory) and np.allclose(memory.point[:, 2], BOX_M) and np.allclose(memory.feature, MUG)
    assert memory.weight.sum() == len(SEEN.points) > 0
    assert (np.ptp(memory.point, axis=0) <= [0.76, 0.76, 1e-9]).all() and (np.diff(memory.cell) > 0).all()
    for depth_m in (CONSTANTS.nearest_m - 0.01, CONSTANTS.farthest_m + 0.01, 0.0):
        assert not len(frame((MIDDLE, depth_m, MUG), wall_m=depth_m).points)
    spike, every = np.full((SIDE, SIDE), BOX_M, np.float32), CONSTANTS.every_px
    spike[every // 2 + 10 * every, every // 2 + 10 * every] += 0.5
    everything = np.ones((1, SIDE, SIDE), bool), MUG[None], np.zeros((1, 3)), CONSTANTS
    flat, spiked = (len(look(depth, AHEAD, *everything).points) for depth in (np.full_like(spike, BOX_M), spike))
    assert spiked == flat - 1, "what sticks out of its surroundings is no point"


@pytest.mark.parametrize(
    ("later", "stays"),
    [
        (frame(), False),
        (frame(camera=standing(0.1), wall_m=9.0), False),
        (frame(camera=standing(-0.1), wall_m=9.0), True),
        (frame(camera=BACKWARDS), True),
        (frame(wall_m=0.0), True),
        (frame((MIDDLE, NEARER, None)), True),
        (frame((MIDDLE, BOX_M, None)), True),
    ],
    ids=["seen through", "near enough", "too far", "out of the picture", "without depth", "hidden", "seen again"],
)
def test_a_later_view_takes_away_what_it_sees_through_and_nothing_else(later, stays):
    before = remember((SEEN,), CONSTANTS)
    after = remember((SEEN, later), CONSTANTS)
    assert same(after, before) if stays else not len(clear(before, later, CONSTANTS)) and not kinds(after)


def test_a_later_detection_is_added_and_renews_the_feature_of_a_surface_that_is_seen_again():
    assert kinds(remember((SEEN, frame((MIDDLE, NEARER, LAMP))), CONSTANTS)) == {0, 1}
    renewed = remember((SEEN, frame((MIDDLE, BOX_M, LAMP))), CONSTANTS)
    assert np.allclose(renewed.feature, LAMP) and set(renewed.seen) == {1}


BOXES = [(MIDDLE, BOX_M, MUG), ((slice(50, 80), slice(50, 80)), BOX_M, LAMP), (CORNER, 2.0, np.eye(3)[2])]


@given(st.permutations(range(3)))
def test_the_order_of_detections_is_of_no_consequence(order):
    one, other = (remember((SEEN, frame(*(BOXES[k] for k in of))), CONSTANTS) for of in (range(3), order))
    assert same(one, other) and len(one)


def test_adding_in_two_steps_is_adding_at_once_but_for_the_time():
    twice = add(add(Memory.empty(), SEEN, 0, CONSTANTS.voxel_m), SEEN, 1, CONSTANTS.voxel_m)
    once = add(Memory.empty(), SEEN, 1, CONSTANTS.voxel_m)
    assert same(replace(twice, weight=twice.weight / 2), once)


def test_noise_is_what_has_too_few_neighbours_of_its_frame():
    least, reach = CONSTANTS.cluster_points, CONSTANTS.cluster_voxels * CONSTANTS.voxel_m

    def row(count: int, at: float = 0.0, seen: int = 0) -> list[tuple[float, int]]:
        return [(at + 0.004 * k, seen) for k in range(count)]

    def kept(*points: tuple[float, int]) -> list[int]:
        x, seen = (np.array(column) for column in zip(*points, strict=True))
        whole = Memory(np.arange(len(x)), np.outer(x, [1.0, 0.0, 0.0]), np.ones(len(x)), seen, np.ones((len(x), 1)))
        return remove_noise(whole, [0, 1], CONSTANTS).cell.tolist()

    assert kept(*row(least)) == list(range(least)) and kept(*row(least - 1)) == []
    assert kept(*row(least - 1), *row(least - 1, seen=1)) == []
    assert kept(*row(least), *row(1, reach + 0.02), *row(1, 2 * reach + 0.1)) == list(range(least + 1)), "the rim, not beyond"


def test_checking_only_what_changed_is_checking_everything():
    frames = SEEN, frame((CORNER, 2.0, LAMP)), frame((MIDDLE, BOX_M, None), (CORNER, 2.0, LAMP)), frame((CORNER, 1.0, MUG))
    memory = Memory.empty()
    for number, one in enumerate(frames):
        memory = remove_noise(clear(memory, one, CONSTANTS), range(len(frames)), CONSTANTS)
        memory = add(memory, one, number, CONSTANTS.voxel_m)
    assert same(memory, remember(frames, CONSTANTS))


RADIUS_M = CONFIG.success.radius_m
CHAIR_MOVED = Query("Chair", Relation.MOVED)
NOTHING = Abstention(AbstentionReason.NOTHING_GROUNDED)


def memory(*voxels: tuple[float, float, np.ndarray, int]) -> Memory:
    """Voxels by x, z, feature and frame, a metre above the floor."""
    point = np.array([(x, 1.0, z) for x, z, _, _ in voxels])
    feature, seen = np.array([one for _, _, one, _ in voxels]), np.array([one for *_, one in voxels])
    number = np.arange(len(voxels))
    return Memory(number, point, np.ones(len(voxels)), seen, feature)


def view(*seen: tuple[tuple[float, float], np.ndarray, float]) -> Look:
    """Detections by place, feature and nearest depth."""
    places = np.array([(x, 1.0, z) for (x, z), _, _ in seen]).reshape(-1, 3)
    camera, nothing = Camera((0.0, 1.5, 0.0), 0.0, 0.0, 90.0), np.zeros((2, 2))
    features, nearest = np.array([one for _, one, _ in seen]).reshape(-1, 3), np.array([one for *_, one in seen])
    return Look(nothing, camera, nothing > 0, np.zeros((0, 3)), np.zeros(0, np.int64), features, places, nearest)


def unlike(cosine: float) -> np.ndarray:
    """A unit feature of that cosine to the mug."""
    return np.array([cosine, 0.0, math.sqrt(1 - cosine**2)])


LESS, MORE = unlike(CONSTANTS.similarity - 0.01), unlike(CONSTANTS.similarity + 0.01)


FRAMES = [view(((0.1, 0.0), MUG, 1.0)), view(((5.2, 5.0), MORE, 1.0), ((5.4, 5.0), MUG, 1.0), ((9.0, 9.0), LAMP, 1.0))]
FOUND = [(0.0, 0.0, MORE, 0), (5.0, 5.0, MUG, 1)]


@pytest.mark.parametrize(
    ("voxels", "frames", "expected"),
    [
        (FOUND, FRAMES, Answer(5.4, 5.0)),
        (FOUND, [FRAMES[0], view()], Answer(5.0, 5.0)),
        (FOUND, [FRAMES[0], view(((5.4, 5.0), MUG, CONSTANTS.detected_m))], Answer(5.0, 5.0)),
        ([(0.0, 0.0, LESS, 0)], [view()], NOTHING),
        ([(0.0, 0.0, LESS, 0)], [view(((1.0, 1.0), LESS, 1.0))], NOTHING),
        ([(0.0, 0.0, LESS, 0)], [view(((1.0, 1.0), MORE, 1.0))], Answer(1.0, 1.0)),
        ([(0.0, 0.0, MORE, 0)], [view()], Answer(0.0, 0.0)),
        # The length of a mean feature does not count.
        ([(0.0, 0.0, 0.2 * MUG, 0), (3.0, 0.0, MORE, 0)], [view()], Answer(0.0, 0.0)),
        ([], [], NOTHING),
    ],
)
def test_the_best_voxel_names_the_frame_whose_best_detection_is_the_answer_if_it_is_like_the_noun(voxels, frames, expected):
    assert locate(memory(*voxels) if voxels else Memory.empty(), frames, MUG, CONSTANTS) == expected


def test_objects_are_groups_of_neighbouring_voxels_that_the_noun_means():
    reach = CONSTANTS.cluster_voxels * CONSTANTS.voxel_m
    one, other = [(reach * 0.9 * k, 0.0, MUG, k) for k in range(4)], [(9.0, reach * 0.9 * k, MUG, 7) for k in range(3)]
    objects = map_noun(memory(*one, *other, (4.0, 4.0, LAMP, 9)), MUG, 0.03, CONSTANTS)
    assert np.allclose(objects.p[np.argsort(objects.p[:, 0])], [(reach * 1.35, 0.0), (9.0, reach * 0.9)])
    assert sorted(objects.last_seen) == [3, 7] and np.allclose(objects.f, MUG)
    assert [track.shape for track in objects.tracks] == [(1, 2)] * 2
    assert not len(map_noun(Memory.empty(), MUG, 0.03, CONSTANTS))


def context(home, first="before", second="after") -> SimpleNamespace:
    """The tours of a home by name or as visits, and its chair as the noun."""
    tours = {"first": getattr(home, first), "second": getattr(home, second)}
    detected = {
        **{name: one.detected for name, one in tours.items()},
        **{one.visit.content: one.detected for one in tours.values()},
    }
    return SimpleNamespace(
        settings=CONFIG,
        tour=lambda which: tours[which].visit,
        detections=lambda which: detected[which if isinstance(which, str) else which.content],
        noun={"chair": home.chair}.__getitem__,
    )


def test_in_a_real_scene_the_memory_of_both_tours_holds_the_new_place_of_a_chair_alone(home):
    (before, _), (both, frames) = (
        remember_tours([(one.visit, one.detected) for one in tours], CONSTANTS)
        for tours in ([home.before], [home.before, home.after])
    )

    def near(memory: Memory, place: tuple[float, float]) -> int:
        places = memory.point[memory.feature @ home.chair > 0.5][:, [0, 2]]
        return int(np.count_nonzero(np.hypot(*(places - place).T) < RADIUS_M))

    assert near(before, home.old) > CONSTANTS.cluster_points and near(before, home.new) == 0
    assert near(both, home.new) > CONSTANTS.cluster_points and near(both, home.old) <= 0.1 * near(before, home.old)
    agent = DynamemAgent(context(home))
    agent.familiarise(home.before.visit)
    agent.revisit(home.after.visit)
    expected = locate(both, frames, home.chair, CONSTANTS)
    assert off(expected, home.new) < RADIUS_M
    assert agent.predict(CHAIR_MOVED) == predict_current(CHAIR_MOVED, context(home))[0] == expected


def test_in_a_real_scene_a_memory_of_each_visit_tells_the_places_apart(home):
    for relation, place in ((Relation.MOVED, home.new), (Relation.FORMER, home.old)):
        assert off(predict_two_visits(Query("Chair", relation), context(home))[0], place) < RADIUS_M
    assert isinstance(predict_two_visits(CHAIR_MOVED, context(home, "before", "before"))[0], Abstention)


def test_a_tour_without_depth_is_one_line(home):
    blind = tuple(replace(one, depth=None) for one in home.before.visit.observations[:1])
    with pytest.raises(ValueError, match=r"^DynaMem reads depth; write needs: \[tours, detections\] in its entry$"):
        look_at_tour(Visit(blind, home.before.visit.reachable), home.before.detected, CONSTANTS)
