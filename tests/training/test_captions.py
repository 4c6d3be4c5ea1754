import numpy as np
import pytest

from ovman.language.vocabulary import SYNONYMS
from training.captions import COLOURS, UNSEEN_WORDS, Senses, colour_word, make_captions, unseen_words


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


WORDNET = """  1 licence | of WordNet
00000001 06 n 03 sofa 0 couch 0 lounge 0 001 @ 00000009 n 0000 | an upholstered seat; "she sat on it"
00000002 06 n 01 couch 0 000 | a narrow bed
00000003 06 n 02 loveseat 0 love_seat 0 000 | a seat for two
00000004 18 n 01 bureau 0 000 | an agency
"""


@pytest.fixture
def senses() -> Senses:
    return Senses.read(WORDNET)


def test_senses_are_those_that_two_nouns_share_or_that_are_the_only_one(senses):
    assert list(senses.of("Sofa")) == [
        (("sofa", "couch", "lounge"), "an upholstered seat"),
        (("sofa", "couch", "lounge"), "an upholstered seat"),
        (("loveseat", "love seat"), "a seat for two"),
    ]
    assert not list(senses.of("Dresser")) and senses.artefacts() == ["couch", "loveseat", "sofa"]


def test_captions_of_a_category_share_one_and_its_own_noun_has_half(senses):
    categories = ["DeskLamp", "FloorLamp", "Sofa"]
    found = make_captions(categories, senses)
    assert np.allclose(found.share.sum(axis=0), 1)
    shares = dict(zip(found.texts, found.share.tolist(), strict=True))
    assert shares["sofa"] == pytest.approx([0, 0, 0.5]) and shares["love seat"][2] > 0
    assert shares["lamp"][0] > 0 and shares["lamp"][1] > 0 and shares["lamp"][2] == 0
    assert found.coloured[len(COLOURS) : 2 * len(COLOURS)] == tuple(f"a {colour} floor lamp" for colour in COLOURS)


def test_words_for_a_test_are_no_captions(senses):
    assert {*UNSEEN_WORDS} <= {*SYNONYMS}
    found = make_captions(sorted(SYNONYMS), senses)
    assert unseen_words(["Sofa"], found) == [("Sofa", "divan"), ("Sofa", "davenport")]
    assert len(unseen_words(SYNONYMS, found)) == sum(map(len, UNSEEN_WORDS.values()))
