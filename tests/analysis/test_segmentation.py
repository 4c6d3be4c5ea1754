from __future__ import annotations

import numpy as np
import pytest

from ovman.analysis.segmentation import joined, segmented
from ovman.perception.overlap import intersection_over_union
from training.detector import count_matches


def blocks(side=60):
    """Three instances side by side: 1200, 800 and 40 px."""
    ids = np.full((side, side), -1)
    ids[:40, :30], ids[:40, 30:50], ids[50:54, 50:] = 0, 1, 2
    return ids


def masks_of(ids, numbers):
    return np.stack([ids == number for number in numbers])


def test_perfect_masks():
    ids = blocks()
    whole = segmented(masks_of(ids, [0, 1, 2]), np.array([0.9, 0.8, 0.7]), ids, 3, 300)
    assert whole.true_object.tolist() == [0, 1] and whole.recalled.all()
    assert whole.object.tolist() == [0, 1, 2] and whole.object_px.tolist() == [1200, 800, 40]
    assert not whole.doubled.any()


@pytest.mark.parametrize(("shift", "right"), [(0, True), (9, True), (11, False), (-11, False)])
def test_half_an_overlap_is_asked_for(shift, right):
    # Two rectangles 30 wide that lie s apart overlap by (30 - s) / (30 + s): a half at s = 10.
    ids = np.full((60, 60), -1)
    ids[:40, 15:45] = 0
    shifted = np.roll(ids == 0, shift, axis=1)[None]
    one = segmented(shifted, np.array([0.9]), ids, 1, 300)
    assert (one.object[0] == 0) == right == one.recalled[0]


def test_of_two_masks_on_one_instance_the_less_sure_is_the_double():
    ids = blocks()
    whole = segmented(masks_of(ids, [0, 1, 0]), np.array([0.5, 0.8, 0.9]), ids, 3, 300)
    assert whole.doubled.tolist() == [True, False, False]


def test_of_equally_sure_masks_the_first_is_not_the_double():
    # Sorting that is not stable keeps the order of a few equal values only by chance; of these hundreds it does not.
    rng = np.random.default_rng(0)
    ids = np.arange(40).reshape(5, 8)
    shows, confidence = rng.integers(0, 40, 400), rng.choice([0.5, 0.7, 0.9], 400)
    whole = segmented(masks_of(ids, shows), confidence, ids, 40, 1)
    first = {}
    for n in sorted(range(400), key=lambda n: -confidence[n]):
        first.setdefault(shows[n], n)
    assert whole.object.tolist() == shows.tolist()
    assert np.flatnonzero(~whole.doubled).tolist() == sorted(first.values())


@pytest.mark.parametrize(("least", "counted"), [(799, [0, 1]), (800, [0, 1]), (801, [0])])
def test_an_instance_of_just_the_least_size_counts(least, counted):
    ids = blocks()
    whole = segmented(masks_of(ids, [0, 1]), np.array([0.9, 0.8]), ids, 3, least)
    assert whole.true_object.tolist() == counted and whole.true_px.tolist() == [1200, 800][: len(counted)]
    # Whether an instance is large enough does not make a mask on it wrong.
    assert whole.object.tolist() == [0, 1]


@pytest.mark.parametrize("count", [0, 3])
@pytest.mark.parametrize("masks", [0, 1])
def test_flags_are_truth_values_and_all_else_whole_numbers(count, masks):
    # A view without masks or instances is joined with others, whose columns would become floats by one of its own.
    ids = blocks() if count else np.full((60, 60), -1)
    whole = segmented(np.zeros((masks, 60, 60), bool), np.full(masks, 0.5), ids, count, 300)
    assert whole.recalled.dtype == whole.doubled.dtype == bool
    for column in (whole.true_object, whole.true_px, whole.px, whole.object, whole.object_px):
        assert np.issubdtype(column.dtype, np.integer)


def test_a_mask_on_nothing_shows_nothing():
    ids = blocks()
    whole = segmented((ids == -1)[None], np.array([0.9]), ids, 3, 300)
    assert whole.object.tolist() == [-1] and whole.object_px.tolist() == [0] and not whole.recalled.any()


@pytest.mark.parametrize("count", [0, 3])
def test_views_without_masks_or_without_instances(count):
    ids = blocks() if count else np.full((60, 60), -1)
    none = segmented(np.zeros((0, 60, 60), bool), np.zeros(0), ids, count, 300)
    assert len(none.px) == 0 and not none.recalled.any()
    assert segmented((ids == -1)[None], np.array([0.5]), ids, count, 300).object.tolist() == [-1]


def test_it_counts_as_overlap_does():
    rng = np.random.default_rng(0)
    parts, total = [], None
    for _ in range(30):
        ids = np.kron(rng.integers(-1, 4, (5, 5)), np.ones((12, 12), int))
        masks = np.stack([np.roll(ids == rng.integers(0, 4), rng.integers(0, 9), axis=1) for _ in range(6)])
        masks = masks[masks.any(axis=(1, 2))]
        parts.append(segmented(masks, rng.random(len(masks)), ids, 4, 300))
        counts = count_matches(*intersection_over_union(masks, ids, 4), 300)
        total = counts if total is None else total + counts
    whole = joined(parts)
    assert (len(whole.true_px), whole.recalled.sum()) == (total.true, total.recalled)
    assert (len(whole.px), (whole.object >= 0).sum()) == (total.found, total.right)
    assert 0 < total.right < total.found and 0 < total.recalled < total.true
