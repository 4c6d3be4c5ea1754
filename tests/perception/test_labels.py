"""Labels and cues: what only the evaluator knows of detections."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ovman.perception.array_file import ArrayFileError
from ovman.perception.cues import Cues, colour_histograms, read_cues, write_cues
from ovman.perception.labels import NOTHING, Labels, intersection_over_union, read_labels, shown, write_labels

RED, GREY, BLUE = (255, 0, 0), (120, 120, 120), (0, 0, 255)


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.integers(1, 30))
def test_a_histogram_is_of_the_masks_pixels_alone_wherever_they_are(seed, hue_bins, saturation_bins):
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (6, 5, 3), dtype=np.uint8)
    masks = rng.random((3, 6, 5)) < 0.4
    found = colour_histograms(rgb, masks, hue_bins, saturation_bins)
    assert found.shape == (3, hue_bins * saturation_bins)
    assert found.sum(axis=1) == pytest.approx(masks.any(axis=(1, 2)).astype(float), abs=1e-5)
    other = np.where(masks[0, ..., None], rgb, rng.integers(0, 256, rgb.shape, dtype=np.uint8))
    assert np.array_equal(colour_histograms(other, masks[:1], hue_bins, saturation_bins), found[:1])
    order = rng.permutation(6)
    assert np.array_equal(colour_histograms(rgb[order], masks[:, order], hue_bins, saturation_bins), found)


def test_hue_and_saturation_and_no_brightness():
    rgb = np.array([[RED, GREY, BLUE, (60, 0, 0)]], np.uint8)
    red, grey, blue, dark = colour_histograms(rgb, np.eye(4, dtype=bool)[:, None], 16, 8)
    assert np.array_equal(red, dark) and red.argmax() % 8 == 7 and grey.argmax() == 0
    assert not (red * blue).any() and not (red * grey).any()


def cues(seed=0, count=3):
    rng = np.random.default_rng(seed)
    return Cues(
        ("Chair|1", "Chair|2"),
        rng.random((count, 4), np.float32),
        rng.random((count, 3), np.float32),
        rng.integers(1, 99, count),
        rng.integers(-1, 2, count).astype(np.int32),
    )


def test_cues_come_back_and_a_tour_of_several_visits_is_written_once(tmp_path):
    one, other, empty = cues(), cues(1, 2), cues(2, 0)
    write_cues(tmp_path / "a.npz", {"x": one, "y": other, "same": one, "nothing": empty})
    found = read_cues(tmp_path / "a.npz")
    assert list(found) == ["x", "y", "same", "nothing"] and found["same"] is found["x"] and len(found["nothing"]) == 0
    for name, was in (("x", one), ("y", other)):
        assert all(np.array_equal(getattr(found[name], field.name), getattr(was, field.name)) for field in fields(Cues))
    write_cues(tmp_path / "b.npz", {"x": one})
    assert (tmp_path / "b.npz").stat().st_size < (tmp_path / "a.npz").stat().st_size
    (tmp_path / "b.npz").write_bytes((tmp_path / "b.npz").read_bytes()[:-40])
    with pytest.raises(ArrayFileError):
        read_cues(tmp_path / "b.npz")


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
