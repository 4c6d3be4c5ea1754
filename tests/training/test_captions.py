import numpy as np
import pytest

from ovman.language.vocabulary import SYNONYMS, nouns
from training.captions import COLOURS, MATERIALS, WORDS, attributes, colour_word, vocabulary


@pytest.mark.parametrize(
    ("rgb", "word"),
    [
        ((10, 10, 10), "black"),
        ((250, 250, 248), "white"),
        ((120, 120, 118), "gray"),
        ((200, 30, 30), "red"),
        ((30, 60, 200), "blue"),
        ((40, 160, 60), "green"),
        ((110, 70, 40), "brown"),
    ],
)
def test_colours_go_by_their_usual_names(rgb, word):
    assert colour_word(np.array(rgb)) == word


def test_every_colour_has_a_word():
    grid = np.stack(np.meshgrid(*[np.linspace(0, 255, 9)] * 3), axis=-1).reshape(-1, 3)
    assert {colour_word(rgb) for rgb in grid} <= set(COLOURS)


def test_attributes_are_of_colour_material_and_size_within_the_category():
    types = np.array(["Mug", "Mug", "Mug", "Bed"])
    materials = np.array(["Ceramic", "", "Metal|Glass", "Wood"])
    colours = np.array([[200, 30, 30], [10, 10, 10], [250, 250, 250], [10, 10, 10]], float)
    sizes = np.array([[0.1, 0.1, 0.1], [0.05, 0.05, 0.05], [0.2, 0.1, 0.1], [2.0, 1, 1]])
    words = [{WORDS[k] for k in np.flatnonzero(row)} for row in attributes(types, materials, colours, sizes)]
    assert words == [{"red", "ceramic"}, {"black", "small"}, {"white", "metal", "glass", "large"}, {"black", "wooden"}]


def test_a_noun_is_right_for_every_category_that_has_it_and_for_no_other():
    categories = sorted(SYNONYMS)
    names, right = vocabulary(categories)
    assert len(set(names)) == len(names) and set(MATERIALS.values()) <= set(WORDS)
    for k, name in enumerate(names):
        assert [c for c, yes in zip(categories, right[k], strict=True) if yes] == [c for c in categories if name in nouns(c)]
