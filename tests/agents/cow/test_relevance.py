"""The localiser, on pictures whose instances are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from ovman.agents.cow.localiser import OpenVocabularyLocaliser, prompt
from tests.agents.cow import world

SIDE = 224
CONSTANTS = world.CONSTANTS.model_copy(update={"image_px": SIDE})

SIZE = 2 * SIDE
BOXES = ((40, 60, 140, 180), (200, 300, 240, 420), (10, 10, 14, 14))
COLOURS = (250, 130, 60)


@dataclass
class Seen:
    masks: np.ndarray


class Boxes:
    """Finds the boxes, whatever the picture."""

    def detect(self, pictures):
        masks = np.zeros((len(BOXES), *pictures[0].shape[:2]), bool)
        for mask, (top, left, bottom, right) in zip(masks, BOXES, strict=True):
            mask[top:bottom, left:right] = True
        return [Seen(masks) for _ in pictures]


class Shades:
    """Embeds a crop by how much of its middle is red; texts all mean red."""

    side_px = 8

    def images(self, crops):
        red = crops[:, 3:5, 3:5, 0].mean(axis=(1, 2)) / 255.0
        return np.stack([red, np.sqrt(1.0 - red**2)], axis=1)

    def texts(self, phrases):
        self.asked = list(phrases)
        return np.tile([1.0, 0.0], (len(phrases), 1))


def localiser(**changes) -> OpenVocabularyLocaliser:
    made = OpenVocabularyLocaliser(Boxes(), Shades(), CONSTANTS.model_copy(update=changes), 300 / 90000, 0.0)
    made.look_for("HousePlant")
    return made


def picture() -> np.ndarray:
    rgb = np.zeros((SIZE, SIZE, 3), np.uint8)
    for (top, left, bottom, right), red in zip(BOXES, COLOURS, strict=True):
        rgb[top:bottom, left:right, 0] = red
    return rgb


@pytest.mark.parametrize(("similarity", "found"), [(0.4, 2), (0.6, 1), (0.99, 0)])
def test_centres_of_what_is_similar_enough_are_relevant(similarity, found):
    relevance = localiser(similarity=similarity, centre_only=True).relevance(picture())
    assert relevance.shape == (SIDE, SIDE) and relevance.sum() == found
    assert found == 0 or relevance[45, 60] == 1.0
    assert found < 2 or relevance[110, 180] == 1.0


def test_all_of_a_box_is_relevant_where_it_is_asked_for():
    relevance = localiser(similarity=0.6, centre_only=False).relevance(picture())
    assert relevance[20:70, 30:90].all() and relevance.sum() == 50 * 60


def test_instances_are_compared_with_the_prompt_and_small_masks_are_none(monkeypatch):
    made = localiser()
    assert made._encoder.asked == [prompt("HousePlant")] == ["a photo of a house plant"]
    boxes, features = made.instances(picture())
    assert [tuple(box) for box in boxes] == [*BOXES[:2]] and len(features) == 2
    monkeypatch.setattr(Boxes, "detect", lambda self, pictures: [Seen(np.zeros((0, SIZE, SIZE), bool))])
    assert not made.relevance(picture()).any()
