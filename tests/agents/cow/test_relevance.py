"""The localiser, on pictures whose instances are known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.cow.localiser import OpenVocabularyLocaliser, prompt
from tests.agents.cow import world

SIDE = 224
CONSTANTS = world.CONSTANTS.model_copy(update={"image_px": SIDE})

SIZE = 2 * SIDE
BOXES = ((40, 60, 140, 180), (200, 300, 240, 420), (10, 10, 14, 14))
COLOURS = (250, 130, 60)


class Boxes:
    """Finds boxes, whatever the picture."""

    def __init__(self, boxes=BOXES):
        self.boxes = boxes

    def detect(self, pictures):
        masks = np.zeros((len(self.boxes), *pictures[0].shape[:2]), bool)
        for mask, (top, left, bottom, right) in zip(masks, self.boxes, strict=True):
            mask[top:bottom, left:right] = True
        return [SimpleNamespace(masks=masks) for _ in pictures]


class Shades:
    """Embeds a crop by how much of its middle is red; texts all mean red."""

    side_px = 8
    contrast = 1.0

    def images(self, crops):
        red = crops[:, 3:5, 3:5, 0].mean(axis=(1, 2)) / 255.0
        return np.stack([red, np.sqrt(1.0 - red**2)], axis=1)

    def texts(self, phrases):
        self.asked = list(phrases)
        return np.tile([1.0, 0.0], (len(phrases), 1))


def localiser(boxes=BOXES, **changes) -> OpenVocabularyLocaliser:
    made = OpenVocabularyLocaliser(Boxes(boxes), Shades(), CONSTANTS.model_copy(update=changes), 300 / 90000, 0.0)
    made.look_for("HousePlant")
    return made


PICTURE = np.zeros((SIZE, SIZE, 3), np.uint8)
for (top, left, bottom, right), red in zip(BOXES, COLOURS, strict=True):
    PICTURE[top:bottom, left:right, 0] = red


@pytest.mark.parametrize(("similarity", "found"), [(0.4, 2), (0.6, 1), (0.99, 0)])
def test_centres_of_what_is_similar_enough_are_relevant(similarity, found):
    relevance = localiser(similarity=similarity, centre_only=True).relevance(PICTURE)
    assert relevance.shape == (SIDE, SIDE) and relevance.sum() == found
    assert relevance[45, 60] == (found > 0) and relevance[110, 180] == (found > 1)


def test_all_of_a_box_is_relevant_where_it_is_asked_for():
    relevance = localiser(similarity=0.6, centre_only=False).relevance(PICTURE)
    assert relevance[20:70, 30:90].all() and relevance.sum() == 50 * 60


def test_instances_are_compared_with_the_prompt_and_small_masks_are_none():
    made = localiser()
    assert made._encoder.asked == [prompt("HousePlant")] == ["a photo of a house plant"]
    boxes, features = made.instances(PICTURE)
    assert [tuple(box) for box in boxes] == [*BOXES[:2]] and len(features) == 2
    assert not localiser(()).relevance(PICTURE).any()


def test_an_image_is_looked_at_once():
    eyes, pictures = localiser(), [PICTURE, PICTURE[::-1], PICTURE.copy(), PICTURE[::-1]]
    looked, detect = [], eyes._detector.detect
    eyes._detector.detect = lambda shown: looked.append(shown) or detect(shown)
    found = [eyes.instances(picture)[1] for picture in pictures]
    assert len(looked) == 2
    assert np.array_equal(found[0], found[2]) and np.array_equal(found[1], found[3])
