"""Which masks are observed: none twice, none too small, and every pixel in one of them at most."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dualmap.observing import colour_cells, filter_masks, histogram
from ovman.settings.config import load

CONSTANTS = load(Path(__file__).parents[3] / "config.yaml").dualmap.observation
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


def test_of_two_masks_that_are_the_same_the_larger_stays():
    large, same = box(0, 0, 20, 20), box(0, 0, 20, 17)
    which, own, _ = filter_masks(np.array([same, large]), painted((large, RED)), 10, CONSTANTS)
    assert which.tolist() == [1] and np.array_equal(own[0], large)


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


def test_what_a_smaller_mask_leaves_too_little_of_goes():
    frame, inside = box(0, 0, 10, 10), box(0, 0, 10, 7)
    which, _, _ = filter_masks(np.array([frame, inside]), painted((frame, RED), (inside, BLUE)), 40, CONSTANTS)
    assert which.tolist() == [1]
    assert filter_masks(np.zeros((0, 40, 40), bool), painted(), 10, CONSTANTS)[1].shape == (0, 40, 40)


def test_a_histogram_counts_each_channel_by_itself():
    counts = histogram(colour_cells(np.array([[0, 15, 16], [255, 15, 17]], np.uint8), 16), 16)
    assert counts.sum() == 6 and counts.shape == (48,)
    assert counts[0] == counts[15] == 1 and counts[16] == 2 and counts[33] == 2
