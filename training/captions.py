"""Captions of crops: templates around nouns, synonyms and attributes."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np

from ovman.language.vocabulary import nouns

TEMPLATES = ("{}", "a {}", "the {}", "a photo of a {}", "this is a {}", "a {} in a room", "there is a {}", "my {}")
HUES = (
    (0.04, "red"),
    (0.105, "orange"),
    (0.19, "yellow"),
    (0.45, "green"),
    (0.7, "blue"),
    (0.83, "purple"),
    (0.95, "pink"),
    (1.01, "red"),
)
"""Upper ends of the hues of a colour word."""
COLOURS = ("black", "white", "gray", "brown", "red", "orange", "yellow", "green", "blue", "purple", "pink")
MATERIALS = {
    "Metal": "metal",
    "Wood": "wooden",
    "Plastic": "plastic",
    "Glass": "glass",
    "Ceramic": "ceramic",
    "Stone": "stone",
    "Fabric": "fabric",
    "Rubber": "rubber",
    "Food": "edible",
    "Paper": "paper",
    "Wax": "wax",
    "Soap": "soapy",
    "Sponge": "soft",
    "Organic": "organic",
    "Leather": "leather",
}
"""Adjectives for AI2-THOR's salient materials."""
SIZES = ("small", "large")
SMALL, LARGE = 0.8, 1.25
"""Size as a share of the median of the category below or above which an object is called small or large."""
WORDS = (*COLOURS, *MATERIALS.values(), *SIZES)


def colour_word(rgb: np.ndarray) -> str:
    """Return the basic colour word of a mean colour (3,) in 0 to 255."""
    hue, saturation, value = colorsys.rgb_to_hsv(*(np.asarray(rgb, dtype=float) / 255))
    if value < 0.18:
        return "black"
    if saturation < 0.16:
        return "white" if value > 0.72 else "gray"
    word = next(word for end, word in HUES if hue < end)
    if word in ("orange", "red", "yellow") and value < 0.55 and saturation < 0.8:
        return "brown"
    return word


def attributes(types: np.ndarray, materials: np.ndarray, colours: np.ndarray, sizes_m: np.ndarray) -> np.ndarray:
    """Return whether each of WORDS applies to each of N crops, (N, len(WORDS)) bool. Arguments: as in `training.crops.Crops`."""
    place = {word: k for k, word in enumerate(WORDS)}
    right = np.zeros((len(types), len(WORDS)), bool)
    for row, colour in zip(right, colours, strict=True):
        row[place[colour_word(colour)]] = True
    for row, names in zip(right, materials, strict=True):
        for name in filter(None, str(names).split("|")):
            if name in MATERIALS:
                row[place[MATERIALS[name]]] = True
    longest = sizes_m.max(axis=1)
    for category in np.unique(types):
        here = types == category
        usual = np.median(longest[here])
        right[here, place["small"]] = longest[here] < SMALL * usual
        right[here, place["large"]] = longest[here] > LARGE * usual
    return right


def vocabulary(categories: Sequence[str]) -> tuple[list[str], np.ndarray]:
    """Return all M nouns of K categories, sorted, and whether a noun applies to a category (M, K) bool."""
    right: dict[str, set[int]] = {}
    for number, category in enumerate(categories):
        for noun in nouns(category):
            right.setdefault(noun, set()).add(number)
    names = sorted(right)
    table = np.zeros((len(names), len(categories)), bool)
    for k, name in enumerate(names):
        table[k, sorted(right[name])] = True
    return names, table
