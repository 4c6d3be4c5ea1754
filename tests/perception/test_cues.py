from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.perception.array_file import ArrayFileError
from ovman.perception.backprojection import Camera, extents, world_points
from ovman.perception.cues import Cues, colours, read_cues, write_cues

RED, GREY, BLUE = (255, 0, 0), (120, 120, 120), (0, 0, 255)


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.integers(1, 30))
def test_a_histogram_is_of_the_masks_pixels_alone_wherever_they_are(seed, hue_bins, saturation_bins):
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (6, 5, 3), dtype=np.uint8)
    masks = rng.random((3, 6, 5)) < 0.4
    found = colours(rgb, masks, hue_bins, saturation_bins)
    assert found.shape == (3, hue_bins * saturation_bins)
    assert found.sum(axis=1) == pytest.approx(masks.any(axis=(1, 2)).astype(float), abs=1e-5)
    other = np.where(masks[0, ..., None], rgb, rng.integers(0, 256, rgb.shape, dtype=np.uint8))
    assert np.array_equal(colours(other, masks[:1], hue_bins, saturation_bins), found[:1])
    order = rng.permutation(6)
    assert np.array_equal(colours(rgb[order], masks[:, order], hue_bins, saturation_bins), found)


def test_hue_and_saturation_and_no_brightness():
    rgb = np.array([[RED, GREY, BLUE, (60, 0, 0)]], np.uint8)
    red, grey, blue, dark = colours(rgb, np.eye(4, dtype=bool)[:, None], 16, 8)
    assert np.array_equal(red, dark) and red.argmax() % 8 == 7 and grey.argmax() == 0
    assert not (red * blue).any() and not (red * grey).any()


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 1.0))
def test_an_extent_is_within_that_of_all_points_and_equal_to_it_for_all_of_them(seed, share):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 5, (8, 9))
    masks = rng.random((2, 8, 9)) < 0.5
    masks[:, 0, 0] = True
    camera = Camera(tuple(rng.normal(size=3)), rng.uniform(0, 360), rng.uniform(-30, 60), 90.0)
    for mask, whole, part in zip(masks, *(extents(depth, masks, camera, some) for some in (1.0, share)), strict=True):
        x, y, z = np.ptp(world_points(depth, mask, camera), axis=0)
        assert whole == pytest.approx([max(x, z), min(x, z), y], abs=1e-9)
        assert (part <= whole + 1e-12).all() and part[0] >= part[1] >= 0


def test_pixels_without_depth_do_not_count():
    depth = np.array([[0.0, 2.0, 2.0, 0.0]])
    camera = Camera((0.0, 1.0, 0.0), 0.0, 0.0, 90.0)
    masks = np.array([[[True, True, True, True]], [[True, False, False, True]]])
    whole, none = extents(depth, masks, camera, 1.0)
    assert whole == pytest.approx([4.0, 0.0, 0.0]) and np.isnan(none).all()


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
