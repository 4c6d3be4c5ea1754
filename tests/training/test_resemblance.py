"""What the thresholds of names and of looks are chosen by."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.training.pictures import Picture, ShownObject
from ovman.training.resemblance import Detection, alike_scores, detections, looked_for, looks, pairs

A, B, C = np.eye(3)


def picture() -> Picture:
    """A mug above a bowl, each of 32 pixels of 8 x 8 but for a row of nothing at the bottom."""
    ids = np.zeros((8, 8), np.int16)
    ids[4:] = 1
    ids[7] = -1
    shown = [ShownObject(kind, f"{kind}_1", (), (0.1, 0.1, 0.1)) for kind in ("Mug", "Bowl")]
    return Picture(np.zeros((8, 8, 3), np.uint8), ids, tuple(shown))


def rows(*which: int) -> np.ndarray:
    mask = np.zeros((8, 8), bool)
    mask[list(which)] = True
    return mask


def test_a_mask_shows_what_most_of_it_is_on():
    masks = [rows(0, 1, 4), rows(3, 4, 5), rows(6, 7), rows(7)]
    found = list(detections(picture(), masks, np.stack([A, B, C, A])))
    assert [(one.category, one.asset) for one in found] == [("Mug", "Mug_1"), ("Bowl", "Bowl_1"), ("Bowl", "Bowl_1"), ("", "")]
    assert [one.feature.argmax() for one in found] == [0, 1, 2, 0]


def test_a_search_finds_the_best_of_the_category_and_the_best_of_others():
    seen = [Detection("Mug", "Mug_1", A), Detection("Bowl", "Bowl_1", B), Detection("", "", C)]
    mug, vase = looked_for(picture(), seen, {"Mug": np.array([0.8, 0.6, 0.0]), "Vase": np.array([0.0, 0.6, 0.8])}, 24)
    assert (mug.right, mug.wrong, mug.shown) == (0.8, 0.6, True)
    assert (vase.right, vase.wrong, vase.shown) == (-1.0, 0.8, False)
    assert not next(looked_for(picture(), seen, {"Bowl": B}, 25)).shown


def test_looks_are_compared_between_halves_and_within_a_category():
    def half(**features: np.ndarray):
        return looks([Detection(name.split("_")[0], name, feature) for name, feature in features.items()])

    same, other = pairs([(half(Mug_1=A, Mug_2=B), half(Mug_1=B)), (half(Bowl_1=A), half(Mug_2=C, Bowl_1=A))])
    assert same == pytest.approx([np.sqrt(2), 0.0])
    # Mug_1 to Mug_2 of the other plan, Mug_2 to Mug_1. The same asset of another plan is not counted.
    assert other == pytest.approx([np.sqrt(2), 0.0])


def test_a_look_is_the_unit_mean_of_what_is_known():
    found = looks([Detection("Mug", "Mug_1", A), Detection("Mug", "Mug_1", B), Detection("Mug", "", C), Detection("", "x", C)])
    assert list(found) == [("Mug", "Mug_1")] and found["Mug", "Mug_1"] == pytest.approx((A + B) / np.sqrt(2))


def test_a_greater_distance_takes_more_for_alike():
    same, other, tried = np.array([0.1, 0.3, 0.5]), np.array([0.2, 0.4, 0.6, 0.8]), np.arange(0.0, 1.0, 0.05)
    found = alike_scores(same, other, tried)
    assert [one.alike for one in found] == sorted(one.alike for one in found)
    assert [one.unlike for one in found] == sorted((one.unlike for one in found), reverse=True)
    (middle,) = alike_scores(same, other, np.array([0.3]))
    assert (middle.alike, middle.unlike) == (pytest.approx(2 / 3), 0.75) and middle.mean == pytest.approx((2 / 3 + 0.75) / 2)
