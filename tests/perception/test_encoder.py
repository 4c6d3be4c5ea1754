"""Crops fade what the mask leaves out; phrases fall into the pieces of BERT's own tokenizer."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.perception.encoder import GREY, crop
from ovman.perception.graph import Graph
from ovman.perception.wordpieces import WordPieces
from ovman.shipped import HOME


def test_a_crop_keeps_the_mask_and_fades_the_rest():
    rgb = np.random.default_rng(0).integers(0, 256, (40, 60, 3), np.uint8)
    mask = np.zeros((40, 60), bool)
    mask[10:20, 30:40] = True
    plain, faded = crop(rgb, mask, 0.1, 14), crop(rgb, mask, 0.1, 14, 0.25)
    assert np.array_equal(plain, rgb[8:22, 28:42]) and np.array_equal(plain[2:12, 2:12], faded[2:12, 2:12])
    outside = np.ones((14, 14), bool)
    outside[2:12, 2:12] = False
    assert np.abs(faded[outside] - (GREY + 0.25 * (plain[outside] - float(GREY)))).max() <= 0.5
    with pytest.raises(ValueError, match="empty mask"):
        crop(rgb, np.zeros_like(mask), 0.1, 14)


@pytest.fixture(scope="module")
def pieces() -> WordPieces:
    return WordPieces(Graph((HOME / "models" / "encoder.text.onnx").read_bytes()).description.facts["pieces"])


@pytest.mark.parametrize(
    ("phrase", "numbers"),
    [
        ("a Chair", [101, 1037, 3242, 102]),
        ("the TV stand", [101, 1996, 2694, 3233, 102]),
        ("knick-knack", [101, 14161, 6799, 1011, 14161, 8684, 102]),
        ("café au lait", [101, 7668, 8740, 21110, 2102, 102]),
        ("plumber's helper", [101, 22088, 5677, 1005, 1055, 2393, 2121, 102]),
        ("cat_dog 3x4", [101, 4937, 1035, 3899, 1017, 2595, 2549, 102]),
        ("unbelievablyxzq", [101, 4895, 8671, 2666, 3567, 6321, 2595, 2480, 4160, 102]),
        ("☃ pouffe", [101, 100, 13433, 16093, 7959, 102]),
    ],
)
def test_pieces_are_those_of_the_model_s_own_tokenizer(pieces, phrase, numbers):
    """The numbers are those of its tokenizer.json, by the package tokenizers 0.23."""
    assert pieces.numbers(phrase).tolist() == [numbers]


def test_a_long_phrase_is_cut(pieces):
    assert pieces.numbers("chair " * 500).shape == (1, 128) and pieces.numbers("").shape == (1, 2)
