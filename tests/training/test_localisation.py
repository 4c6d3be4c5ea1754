"""How well CoW's localiser tells what is of a category."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ovman.training.localisation import Looked, looked_for, scores
from ovman.training.pictures import Picture, ShownObject

LOOKED = [Looked(0.6, 0.5, True), Looked(-1.0, 0.55, True), Looked(0.52, -1.0, True), Looked(-1.0, 0.4, False)]


def test_scores_count_what_is_found_rightly_wrongly_and_not():
    low, high = scores(LOOKED, np.array([0.45, 0.53]))
    assert (low.right, low.wrong, low.missed) == (2, 2, 1) and low.f1 == pytest.approx(4 / 7)
    assert (high.right, high.wrong, high.missed) == (1, 1, 2) and high.f1 == pytest.approx(2 / 5)


def test_a_higher_threshold_finds_less():
    found = scores(LOOKED, np.arange(0.3, 0.7, 0.01))
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
    mug, bowl, vase = looked_for(picture, texts, Eyes(), 10.0)
    assert (mug.right, mug.wrong, mug.shown) == (0.8, 0.6, True)
    assert (bowl.right, bowl.wrong, bowl.shown) == (0.2, 0.1, True)
    assert (vase.right, vase.wrong, vase.shown) == (-1.0, 0.4, False)
    assert not next(looked_for(picture, texts, Eyes(), 17.0)).shown
