"""DynaMem's memory: what a later view sees through is gone, what is hidden stays, and what is seen anew is renewed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dynamem.memory import Look, Memory, add, clear, look, remember, remove_noise
from ovman.perception.backprojection import Camera
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
    return set(memory.feature.argmax(axis=1).tolist())


def same(one: Memory, other: Memory) -> bool:
    return all(np.allclose(getattr(one, name), getattr(other, name)) for name in Memory.__slots__)


SEEN = frame((MIDDLE, BOX_M, MUG))


def test_points_are_where_the_pixels_show_them_and_have_their_detections_feature():
    memory = remember([SEEN], CONSTANTS)
    assert len(memory) and np.allclose(memory.point[:, 2], BOX_M) and np.allclose(memory.feature, MUG)
    rows, columns, away, inside = SEEN.project(memory.point)
    assert inside.all() and np.allclose(away, BOX_M)
    assert SEEN.masked[rows, columns].all() and memory.weight.sum() == len(SEEN.points) > 0
    assert (np.ptp(memory.point, axis=0) <= [0.76, 0.76, 1e-9]).all() and (np.diff(memory.cell) > 0).all()


def test_what_a_later_view_sees_through_is_forgotten():
    assert not len(remember([SEEN, frame()], CONSTANTS))


def test_what_is_hidden_behind_something_nearer_is_kept():
    memory = remember([SEEN, frame((MIDDLE, BOX_M - 0.5, LAMP))], CONSTANTS)
    assert kinds(memory) == {0, 1}
    undetected = remember([SEEN, frame((MIDDLE, BOX_M - 0.5, None))], CONSTANTS)
    assert same(undetected, remember([SEEN], CONSTANTS))


def test_what_is_out_of_the_picture_or_too_far_or_without_depth_is_kept():
    before = remember([SEEN], CONSTANTS)
    behind = Camera((0.0, 1.5, 0.0), 180.0, 0.0, 90.0)
    far = Camera((0.0, 1.5, BOX_M - CONSTANTS.farthest_m - 0.1), 0.0, 0.0, 90.0)
    for later in (frame(camera=behind), frame(camera=far, wall_m=9.0), frame(wall_m=0.0)):
        assert same(clear(before, later, CONSTANTS), before)
    near = Camera((0.0, 1.5, BOX_M - CONSTANTS.farthest_m + 0.1), 0.0, 0.0, 90.0)
    assert not len(clear(before, frame(camera=near, wall_m=9.0), CONSTANTS))


def test_a_surface_that_is_seen_again_takes_the_feature_of_its_detection_and_keeps_its_own_without_one():
    renewed = remember([SEEN, frame((MIDDLE, BOX_M, LAMP))], CONSTANTS)
    assert np.allclose(renewed.feature, LAMP) and set(renewed.seen) == {1}
    assert same(remember([SEEN, frame((MIDDLE, BOX_M, None))], CONSTANTS), remember([SEEN], CONSTANTS))


def test_a_thing_that_moved_is_remembered_where_it_is_alone():
    moved = frame((CORNER, BOX_M, MUG))
    alone, after = remember([moved], CONSTANTS), remember([SEEN, moved], CONSTANTS)
    assert np.array_equal(alone.cell, after.cell) and np.allclose(alone.feature, after.feature) and (after.seen == 1).all()


@given(st.permutations(range(3)))
def test_the_order_of_detections_is_of_no_consequence(order):
    overlapping = (slice(50, 80), slice(50, 80))
    boxes = [(MIDDLE, BOX_M, MUG), (overlapping, BOX_M, LAMP), (CORNER, 2.0, np.eye(3)[2])]
    depth = np.full((SIDE, SIDE), WALL_M, np.float32)
    for box, depth_m, _ in boxes:
        depth[box] = depth_m
    masks = np.zeros((3, SIDE, SIDE), bool)
    for mask, (box, _, _) in zip(masks, boxes, strict=True):
        mask[box] = True
    features = np.array([feature for _, _, feature in boxes])
    one, other = (
        remember([SEEN, look(depth, AHEAD, masks[of], features[of], np.zeros((3, 3)), CONSTANTS)], CONSTANTS)
        for of in (list(range(3)), list(order))
    )
    assert same(one, other) and len(one)


def test_a_pixel_of_two_detections_counts_for_both():
    memory = remember([frame((MIDDLE, BOX_M, MUG), (MIDDLE, BOX_M, LAMP))], CONSTANTS)
    assert np.allclose(memory.feature, (MUG + LAMP) / 2)


def test_adding_in_two_steps_is_adding_at_once_but_for_the_time():
    twice = add(add(Memory.empty(), SEEN, 0, CONSTANTS.voxel_m), SEEN, 1, CONSTANTS.voxel_m)
    once = add(Memory.empty(), SEEN, 1, CONSTANTS.voxel_m)
    assert np.array_equal(twice.cell, once.cell) and np.allclose(twice.feature, once.feature)
    assert np.allclose(twice.point, once.point) and np.array_equal(twice.weight, 2 * once.weight) and (twice.seen == 1).all()


def test_noise_is_what_has_too_few_neighbours_of_its_frame():
    voxel_m, least = CONSTANTS.voxel_m, CONSTANTS.cluster_points

    def row(count: int, at: float, seen: int) -> list[tuple[float, float, float, int]]:
        return [(at + 0.004 * k, 0.0, 0.0, seen) for k in range(count)]

    def kept(*rows) -> list[int]:
        every = [point for row in rows for point in row]
        point, seen = np.array([one[:3] for one in every]), np.array([one[3] for one in every])
        number = np.arange(len(every))
        memory = Memory(number, point, np.ones(len(every)), seen, number, np.ones((len(every), 1)))
        return remove_noise(memory, [0, 1], CONSTANTS).cell.tolist()

    assert kept(row(least, 0.0, 0)) == list(range(least)) and kept(row(least - 1, 0.0, 0)) == []
    assert kept(row(least - 1, 0.0, 0), row(least - 1, 0.0, 1)) == []
    reach = CONSTANTS.cluster_voxels * voxel_m
    rim, beyond = row(1, reach + 0.02, 0), row(1, 2 * reach + 0.1, 0)
    assert kept(row(least, 0.0, 0), rim, beyond) == list(range(least + 1))


def test_checking_only_what_changed_is_checking_everything():
    frames = [SEEN, frame((CORNER, 2.0, LAMP)), frame((MIDDLE, BOX_M, None), (CORNER, 2.0, LAMP)), frame((CORNER, 1.0, MUG))]
    memory = Memory.empty()
    for number, one in enumerate(frames):
        memory = remove_noise(clear(memory, one, CONSTANTS), range(len(frames)), CONSTANTS)
        memory = add(memory, one, number, CONSTANTS.voxel_m)
    assert same(memory, remember(frames, CONSTANTS))


@pytest.mark.parametrize("first", range(5))
def test_going_on_from_a_memory_is_remembering_at_once(first):
    frames = [SEEN, frame((CORNER, 2.0, LAMP)), frame((MIDDLE, BOX_M, None), (CORNER, 2.0, LAMP)), frame((CORNER, 1.0, MUG))]
    found, once = (
        remember(frames[first:], CONSTANTS, remember(frames[:first], CONSTANTS), first),
        remember(frames, CONSTANTS),
    )
    assert all(np.array_equal(getattr(found, name), getattr(once, name)) for name in Memory.__slots__)


@pytest.mark.parametrize("depth_m", [CONSTANTS.nearest_m - 0.01, CONSTANTS.farthest_m + 0.01, 0.0])
def test_what_is_too_near_or_too_far_becomes_no_point(depth_m):
    assert not len(frame((MIDDLE, depth_m, MUG), wall_m=depth_m).points)


def test_pixels_that_stick_out_of_their_surroundings_become_no_points():
    depth, mask = np.full((SIDE, SIDE), BOX_M, np.float32), np.ones((1, SIDE, SIDE), bool)
    every = CONSTANTS.every_px
    flat = look(depth, AHEAD, mask, MUG[None], np.zeros((1, 3)), CONSTANTS)
    depth[every // 2 + 10 * every, every // 2 + 10 * every] += 0.5
    assert len(look(depth, AHEAD, mask, MUG[None], np.zeros((1, 3)), CONSTANTS).points) == len(flat.points) - 1


def test_nothing_is_remembered_of_nothing():
    assert not len(remember([], CONSTANTS)) and not len(remember([frame(), frame()], CONSTANTS))
