"""The scores by which the thresholds of the baselines are chosen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from training.pictures import Picture, ShownObject
from training.thresholds import (
    Detection,
    Search,
    average_looks,
    measure_pairs,
    name_detections,
    score_distances,
    score_searches,
    search_boxes,
    search_detections,
)

A, B, C = np.eye(3)
SEARCHES = [Search(0.6, 0.5, True), Search(-1.0, 0.55, True), Search(0.52, -1.0, True), Search(-1.0, 0.4, False)]


def test_scores_count_what_is_found_rightly_wrongly_and_not():
    low, high = score_searches(SEARCHES, np.array([0.45, 0.53]))
    assert (low.right, low.wrong, low.missed) == (2, 2, 1) and low.f1 == pytest.approx(4 / 7)
    assert (high.right, high.wrong, high.missed) == (1, 1, 2) and high.f1 == pytest.approx(2 / 5)


def test_a_higher_threshold_finds_less():
    found = score_searches(SEARCHES, np.arange(0.3, 0.7, 0.01))
    for one, next_one in zip(found, found[1:], strict=False):
        assert next_one.right <= one.right and next_one.wrong <= one.wrong and next_one.missed >= one.missed


class Eyes:
    """Two boxes, the first on the mug."""

    def instances(self, rgb):
        return np.array([[0.0, 0.0, 4.0, 4.0], [4.0, 4.0, 8.0, 8.0]]), np.array([[1.0, 0.0], [0.0, 1.0]])


def test_a_centre_on_the_category_is_right_and_one_beside_it_wrong():
    ids = np.full((8, 8), -1, np.int16)
    ids[:4, :4] = 0
    ids[4:, 4:] = 1
    shown = ShownObject("Mug", "Mug_1", (), (0.1, 0.1, 0.1))
    picture = Picture(np.zeros((8, 8, 3), np.uint8), ids, (shown, replace(shown, type="Bowl")))
    texts = {"Mug": np.array([0.8, 0.6]), "Bowl": np.array([0.1, 0.2]), "Vase": np.array([0.3, 0.4])}
    mug, bowl, vase = search_boxes(picture, texts, Eyes(), 10.0)
    assert (mug.right, mug.wrong, mug.shown) == (0.8, 0.6, True)
    assert (bowl.right, bowl.wrong, bowl.shown) == (0.2, 0.1, True)
    assert (vase.right, vase.wrong, vase.shown) == (-1.0, 0.4, False)
    assert not next(search_boxes(picture, texts, Eyes(), 17.0)).shown


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
    found = list(name_detections(picture(), masks, np.stack([A, B, C, A])))
    assert [(one.category, one.asset) for one in found] == [("Mug", "Mug_1"), ("Bowl", "Bowl_1"), ("Bowl", "Bowl_1"), ("", "")]
    assert [one.feature.argmax() for one in found] == [0, 1, 2, 0]


def test_a_search_finds_the_best_of_the_category_and_the_best_of_others():
    seen = [Detection("Mug", "Mug_1", A), Detection("Bowl", "Bowl_1", B), Detection("", "", C)]
    mug, vase = search_detections(picture(), seen, {"Mug": np.array([0.8, 0.6, 0.0]), "Vase": np.array([0.0, 0.6, 0.8])}, 24)
    assert (mug.right, mug.wrong, mug.shown) == (0.8, 0.6, True)
    assert (vase.right, vase.wrong, vase.shown) == (-1.0, 0.8, False)
    assert not next(search_detections(picture(), seen, {"Bowl": B}, 25)).shown


def test_looks_are_compared_between_halves_and_within_a_category():
    def half(**features: np.ndarray):
        return average_looks([Detection(name.split("_")[0], name, feature) for name, feature in features.items()])

    same, other = measure_pairs([(half(Mug_1=A, Mug_2=B), half(Mug_1=B)), (half(Bowl_1=A), half(Mug_2=C, Bowl_1=A))])
    assert same == pytest.approx([np.sqrt(2), 0.0])
    # Mug_1 to Mug_2 of the other plan, Mug_2 to Mug_1. The same asset of another plan is not counted.
    assert other == pytest.approx([np.sqrt(2), 0.0])


def test_a_look_is_the_unit_mean_of_what_is_known():
    found = average_looks(
        [Detection("Mug", "Mug_1", A), Detection("Mug", "Mug_1", B), Detection("Mug", "", C), Detection("", "x", C)]
    )
    assert list(found) == [("Mug", "Mug_1")] and found["Mug", "Mug_1"] == pytest.approx((A + B) / np.sqrt(2))


def test_a_greater_distance_takes_more_for_alike():
    same, other, tried = np.array([0.1, 0.3, 0.5]), np.array([0.2, 0.4, 0.6, 0.8]), np.arange(0.0, 1.0, 0.05)
    found = score_distances(same, other, tried)
    assert [one.alike for one in found] == sorted(one.alike for one in found)
    assert [one.unlike for one in found] == sorted((one.unlike for one in found), reverse=True)
    (middle,) = score_distances(same, other, np.array([0.3]))
    assert (middle.alike, middle.unlike) == (pytest.approx(2 / 3), 0.75) and middle.mean == pytest.approx((2 / 3 + 0.75) / 2)
