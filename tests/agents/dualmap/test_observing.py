"""DualMap's observations: masks by properties, and a frame of boxes before a wall."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dualmap.observing import Observer, filter_masks
from ovman.perception.backprojection import Camera, world_points
from ovman.perception.encoder import unit
from tests.arms import CONFIG

CONSTANTS = CONFIG.dualmap.observation
RED, BLUE = (200, 30, 30), (30, 30, 200)


def box(top, left, bottom, right, side=40) -> np.ndarray:
    mask = np.zeros((side, side), bool)
    mask[top:bottom, left:right] = True
    return mask


def painted(*parts) -> np.ndarray:
    rgb = np.zeros((40, 40, 3), np.uint8)
    for mask, colour in parts:
        rgb[mask] = colour
    return rgb


boxes = st.lists(st.tuples(*4 * [st.integers(0, 40)]), max_size=9)


@given(boxes, st.integers(1, 60), st.integers(0, 5))
def test_what_is_left_is_disjoint_large_enough_and_part_of_what_was_found(corners, min_mask_px, seed):
    masks = np.array([box(min(a, c), min(b, d), max(a, c), max(b, d)) for a, b, c, d in corners]).reshape(-1, 40, 40)
    rgb = np.random.default_rng(seed).choice(np.array([RED, BLUE], np.uint8), (40, 40))
    which, own, whole = filter_masks(masks, rgb, min_mask_px, CONSTANTS)
    assert len(which) == len(own) == len(whole) == len(set(which.tolist()))
    assert (own.sum(axis=0) <= 1).all()
    assert all(mask.sum() >= min_mask_px for mask in own)
    for k, part, all_of_it in zip(which, own, whole, strict=True):
        assert not (part & ~all_of_it).any()
        assert not (masks[k] & ~all_of_it).any()
        assert not (all_of_it & ~masks.any(axis=0)).any()


@pytest.mark.parametrize(
    ("found", "colours", "min_mask_px", "left"),
    [
        ([box(0, 0, 20, 17), box(0, 0, 20, 20)], [RED, RED], 10, 1),  # the same: the larger stays
        ([box(0, 0, 10, 10), box(0, 0, 10, 7)], [RED, BLUE], 40, 1),  # the smaller leaves too little of the larger
    ],
)
def test_one_of_two_masks_stays(found, colours, min_mask_px, left):
    which, own, _ = filter_masks(np.array(found), painted(*zip(found, colours, strict=True)), min_mask_px, CONSTANTS)
    assert which.tolist() == [left] and np.array_equal(own[0], found[left])
    assert filter_masks(np.zeros((0, 40, 40), bool), painted(), 10, CONSTANTS)[1].shape == (0, 40, 40)


def test_overlapping_masks_of_the_same_colours_are_one_and_others_are_not():
    left, right = box(0, 0, 20, 20), box(0, 18, 20, 30)
    which, own, _ = filter_masks(np.array([left, right]), painted((left, RED), (right, RED)), 10, CONSTANTS)
    assert which.tolist() == [0] and np.array_equal(own[0], left | right)
    which, own, whole = filter_masks(np.array([left, right]), painted((left, RED), (right, BLUE)), 10, CONSTANTS)
    assert which.tolist() == [0, 1]
    assert np.array_equal(own[1], right) and np.array_equal(own[0], left & ~right)
    assert np.array_equal(whole[0], left) and np.array_equal(whole[1], right)
    apart = box(0, 24, 20, 30)
    assert len(filter_masks(np.array([left, apart]), painted((left | apart, RED)), 10, CONSTANTS)[0]) == 2


RUNS, SIDE_PX, WALL_M = 3, 240, 4.0
CAMERA = Camera((1.0, 1.5, -2.0), 30.0, 0.0, 90.0)
BOXES = {  # depth in metres by place in the picture
    (20, 20, 110, 80): 1.5,
    (20, 80, 110, 100): 2.0,
    (150, 60, 230, 200): 2.5,
    (0, 210, 8, 214): 2.0,
}


class Detector:
    """Finds what it is told to."""

    def __init__(self, masks):
        self.found = SimpleNamespace(masks=masks, confidence=np.linspace(0.9, 0.3, len(masks)).astype(np.float32))

    def detect(self, pictures):
        return [self.found for _ in pictures]


class Encoder:
    """Embeds a crop by its mean colour, and words by their letters; remembers the crops."""

    side_px, size, contrast = 32, 12, 1.0

    def __init__(self):
        self.crops = []

    def images(self, crops):
        self.crops += list(crops)
        means = crops.reshape(len(crops), -1, 3).mean(axis=1) - 100.0
        return unit(np.tile(means, 4) * np.linspace(1, 2, self.size))

    def texts(self, phrases):
        return unit(np.array([[sum(map(ord, p)) % (7 + k) - 3.0 for k in range(self.size)] for p in phrases]))


MASKS = np.array([box(*at, SIDE_PX) for at in BOXES])


def frame() -> SimpleNamespace:
    """Boxes of different colours before a wall, the last one too small."""
    rgb, depth = np.full((SIDE_PX, SIDE_PX, 3), 128, np.uint8), np.full((SIDE_PX, SIDE_PX), WALL_M, np.float32)
    for number, (mask, depth_m) in enumerate(zip(MASKS, BOXES.values(), strict=True)):
        rgb[mask], depth[mask] = (60 * number, 200 - 60 * number, 90), depth_m
    return SimpleNamespace(rgb=rgb, depth=depth, camera=CAMERA)


def look(frames, masks=MASKS, seed=0, encoder=None):
    draws = [[np.random.default_rng([seed, k, run]) for run in range(RUNS)] for k in range(len(frames))]
    return Observer(Detector(masks), encoder or Encoder(), CONSTANTS).look(frames, draws)


def test_clouds_are_of_the_pixels_of_their_masks_in_every_run():
    ((shot, masks),) = look([frame()])
    assert len(shot.seen) == len(masks) == 3
    for one, mask, expected in zip(shot.seen, masks, sorted(MASKS[:3], key=np.sum)[::-1], strict=True):
        assert np.array_equal(mask, expected) and len(one.clouds) == RUNS
        points = {tuple(point) for point in world_points(frame().depth, mask, CAMERA).astype(np.float32)}
        for cloud in one.clouds:
            assert cloud.dtype == np.float32 and {tuple(point) for point in cloud} <= points
            assert CONSTANTS.cluster_points <= len(cloud) <= mask.sum()
        heights = np.concatenate(one.clouds)[:, 1]
        assert one.middle_m == pytest.approx((heights.min() + heights.max()) / 2)
    assert shot.top_m == pytest.approx(1.5 + 0.9 * WALL_M, abs=0.2), "without the highest rows"


def test_a_feature_mixes_the_crop_and_the_class_that_is_most_like_it():
    encoder = Encoder()
    ((shot, _),) = look([frame()], encoder=encoder)
    names = Observer(Detector(MASKS), encoder, CONSTANTS).class_features
    for one, crop in zip(shot.seen, encoder.crops.copy(), strict=True):
        image = encoder.images(crop[None])[0]
        assert one.class_id == (names @ image).argmax()
        mixed = CONSTANTS.image_weight * image + CONSTANTS.text_weight * names[one.class_id]
        assert one.feature.dtype == np.float32 and one.feature == pytest.approx(mixed / np.linalg.norm(mixed), abs=1e-5)


def test_the_same_view_gives_clouds_of_the_same_density_whatever_its_size():
    whole = frame()
    half = SimpleNamespace(rgb=whole.rgb[::2, ::2], depth=whole.depth[::2, ::2], camera=CAMERA)
    shots = look([whole])[0][0], look([half], MASKS[:, ::2, ::2])[0][0]
    points = [sum(len(cloud) for one in shot.seen for cloud in one.clouds) for shot in shots]
    assert points[1] == pytest.approx(points[0], rel=0.05)
    ((shot, masks),) = look([whole], np.zeros((0, SIDE_PX, SIDE_PX), bool))
    assert (shot.seen, masks) == ((), [])
