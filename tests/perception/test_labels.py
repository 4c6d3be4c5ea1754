"""Labels, which only the evaluator knows of detections."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ovman.perception.labels import NOTHING, Labels, intersection_over_union, read_labels, shown, write_labels

PICTURES = arrays(np.int64, (5, 6), elements=st.integers(-2, 3))
MASKS = arrays(bool, (4, 5, 6))


@given(MASKS, PICTURES)
def test_a_mask_shows_the_instance_of_the_largest_overlap_from_a_half_on(masks, ids):
    iou, sizes = intersection_over_union(masks, ids, 4)
    for value, overlaps in zip(shown(masks, ids).tolist(), iou, strict=True):
        best = overlaps.max()
        assert (value == NOTHING) == (best < 0.5)
        if value != NOTHING:
            equal = np.flatnonzero(overlaps == best)
            assert value in equal and sizes[value] == sizes[equal].max()


@given(PICTURES)
def test_the_mask_of_an_instance_shows_it_and_no_mask_shows_what_is_none(ids):
    for value in np.unique(ids):
        assert shown((ids == value)[None], ids).tolist() == [value if value >= 0 else NOTHING]
    assert shown(np.zeros((1, 5, 6), bool), ids).tolist() == [NOTHING]


def test_labels_come_back(tmp_path):
    names = ("Chair", "Lamp")
    made = {
        "untouched": Labels(names, np.array([0, NOTHING, 1]), np.array([300, 400, 90_000])),
        "nothing seen": Labels(names, np.zeros(0, int), np.zeros(0, int)),
        "gone": Labels(names, np.array([1]), np.array([301])),
    }
    write_labels(tmp_path / "a.npz", made)
    found = read_labels(tmp_path / "a.npz")
    assert list(found) == list(made)
    for name, was in made.items():
        now = found[name]
        assert now.categories == names and len(now) == len(was)
        assert np.array_equal(now.category, was.category) and np.array_equal(now.pixels, was.pixels)
    write_labels(tmp_path / "none.npz", {})
    assert read_labels(tmp_path / "none.npz") == {}
