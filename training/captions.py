"""Captions of crops: nouns, synonyms of the vocabulary and of WordNet, glosses, and nouns with a colour."""

from __future__ import annotations

import colorsys
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.language.vocabulary import nouns

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
ARTEFACT, FOOD, PLANT = "06", "13", "20"
"""WordNet's files of the senses that a category can have."""
MISREAD = frozenset(["Toilet", "Window"])
"""Categories whose nouns WordNet knows as a room and as a drug."""
OWN_SHARE = 0.5
"""Share of a category's own noun among its captions; the others share the rest."""
UNSEEN_WORDS = {
    "ArmChair": ("wing chair", "fauteuil"),
    "Bed": ("bunk", "cot"),
    "Box": ("crate", "cardboard container"),
    "Chair": ("swivel chair", "side chair"),
    "CoffeeMachine": ("percolator", "coffee brewer"),
    "CoffeeTable": ("magazine table",),
    "Desk": ("escritoire", "secretary desk"),
    "DeskLamp": ("desk light", "table light"),
    "DiningTable": ("supper table",),
    "DogBed": ("puppy cushion", "bed for a dog"),
    "Dresser": ("chiffonier", "tallboy"),
    "FloorLamp": ("torchiere", "floor light"),
    "Fridge": ("freezer", "cooler"),
    "GarbageCan": ("rubbish bin", "litter bin"),
    "HousePlant": ("indoor plant", "ficus"),
    "Laptop": ("macbook", "notebook PC"),
    "LaundryHamper": ("washing basket",),
    "Pillow": ("bolster", "headrest"),
    "Pot": ("stewpot", "casserole"),
    "ShelvingUnit": ("storage shelves", "shelf unit"),
    "SideTable": ("night table", "bedside cabinet"),
    "Sofa": ("divan", "davenport"),
    "Stool": ("milking stool", "tabouret"),
    "TVStand": ("television cabinet", "TV bench"),
    "TeddyBear": ("stuffed animal", "soft toy"),
    "Television": ("flat panel display", "television screen"),
    "Vase": ("amphora", "flower holder"),
}
"""Words for a test: no caption has them."""


@dataclass(frozen=True, slots=True, eq=False)
class Captions:
    """The captions of K categories.

    texts: M captions without colour; share: (M, K) float32, the part of each in the captions of a category; coloured: of each
    category in turn, "a COLOUR NOUN" for all of COLOURS.
    """

    texts: tuple[str, ...]
    share: np.ndarray
    coloured: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Senses:
    """The nouns of WordNet. senses: all senses of a noun in lower case; its file, words and gloss each."""

    senses: dict[str, list[tuple[str, tuple[str, ...], str]]]

    @staticmethod
    def read(data: str) -> Senses:
        """Read WordNet's file data.noun."""
        found: dict[str, list[tuple[str, tuple[str, ...], str]]] = {}
        for line in data.splitlines():
            if line[:1].isdigit():  # the licence is indented
                fields, gloss = line.split(" | ", 1)
                _, kind, _, count, *rest = fields.split(" ")
                words = tuple(word.replace("_", " ") for word in rest[: 2 * int(count, 16) : 2])
                for word in words:
                    found.setdefault(word.lower(), []).append((kind, words, gloss.split(";")[0].strip()))
        return Senses(found)

    def of(self, category: str) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yield words and gloss of the senses of a category: of nouns that have one sense, or that two of its nouns share."""
        own = {noun.lower() for noun in nouns(category)}
        for noun in () if category in MISREAD else nouns(category):
            every = self.senses.get(noun.lower(), [])
            for kind, words, gloss in every:
                shared = len(own & {word.lower() for word in words})
                if kind in (ARTEFACT, FOOD, PLANT) and (len(every) == 1 or shared > 1):
                    yield words, gloss

    def artefacts(self) -> list[str]:
        """Return the first words of all senses that are artefacts."""
        return sorted({words[0] for every in self.senses.values() for kind, words, _ in every if kind == ARTEFACT})


def make_captions(categories: Sequence[str], senses: Senses) -> Captions:
    """Return the captions of categories; one that several have counts for each."""
    found: dict[str, set[int]] = {}
    for number, category in enumerate(categories):
        further = [text for words, gloss in senses.of(category) for text in (*words, gloss)]
        for text in (*nouns(category), *further):
            if text not in UNSEEN_WORDS.get(category, ()):
                found.setdefault(text, set()).add(number)
    texts = tuple(sorted(found))
    share = np.zeros((len(texts), len(categories)), np.float32)
    for row, text in zip(share, texts, strict=True):
        row[sorted(found[text])] = 1
    own = [texts.index(nouns(category)[0]) for category in categories]
    share *= (1 - OWN_SHARE) / np.maximum(share.sum(axis=0) - 1, 1)
    share[own, np.arange(len(categories))] = OWN_SHARE
    coloured = tuple(f"a {colour} {nouns(category)[0]}" for category in categories for colour in COLOURS)
    return Captions(texts, share / share.sum(axis=0), coloured)


def unseen_words(categories: Collection[str], captions: Captions) -> list[tuple[str, str]]:
    """Return (category, word) for the words of UNSEEN_WORDS that are of these categories and that no caption is."""
    return [(c, word) for c, words in UNSEEN_WORDS.items() if c in categories for word in words if word not in captions.texts]


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
