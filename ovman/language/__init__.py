"""Nouns of categories in singular and plural, and the sentence that an agent is given: one form for each change relation."""

from __future__ import annotations

import re

# Categories whose name, split at its capitals, is not idiomatic.
_SPOKEN = {
    "ArmChair": "armchair",
    "BasketBall": "basketball",
    "CounterTop": "countertop",
    "Desktop": "desktop computer",
    "KeyChain": "keychain",
    "RoomDecor": "room decoration",
    "SoapBar": "bar of soap",
    "TableTopDecor": "table decoration",
}

# Of categories, and of synonyms by their last word.
_PLURAL = frozenset({"blinds", "boots", "curtains"})
_PLURAL_HEADS = frozenset({"drapes", "keys", "shades", "shelves", "shoes", "tissues"})

_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|[0-9]+")


def noun(category: str) -> str:
    """Return the noun phrase of an AI2-THOR category, without article: "HousePlant" -> "house plant", "TVStand" -> "TV stand".

    Works for any name in CamelCase; abbreviations keep their capitals. Distinct for the 118 categories of the iTHOR floor plans.

    Raises:
        ValueError: The name has no letters.
    """
    if category in _SPOKEN:
        return _SPOKEN[category]
    words = _WORD.findall(category)
    if not words:
        raise ValueError(f"{category!r} is not the name of a category")
    return " ".join(word if len(word) > 1 and word.isupper() else word.lower() for word in words)


def is_plural_category(noun_phrase: str) -> bool:
    """Say whether one object of a category goes by a plural noun: "the curtains were moved"."""
    return noun_phrase in _PLURAL


def is_plural(noun_phrase: str) -> bool:
    """Say whether one object goes by a plural noun, synonyms included.

    "The drapes were moved", but "the pair of boots was moved".
    """
    words = noun_phrase.split()
    return "of" not in words and (words[-1] in _PLURAL_HEADS or is_plural_category(words[-1]))


def other_number(noun_phrase: str) -> str:
    """Return the plural of a singular noun phrase, or the singular of a plural one; its head is the word before "of" or "to".

    >>> other_number("loaf of bread"), other_number("window blinds"), other_number("tap")
    ('loaves of bread', 'window blind', 'taps')
    """
    words = noun_phrase.split()
    head = next((k for k, word in enumerate(words) if word in ("of", "to")), len(words)) - 1
    turned = _singular(words[head]) if is_plural(noun_phrase) else _plural(words[head])
    return " ".join([*words[:head], turned, *words[head + 1 :]])


def _plural(word: str) -> str:
    if re.search(r"[^aeiou]y$", word):
        return word[:-1] + "ies"
    if word in ("knife", "loaf", "shelf", "bookshelf"):
        return re.sub(r"fe?$", "ves", word)
    return word + ("es" if re.search(r"(s|x|z|ch|sh)$", word) else "s")


def _singular(word: str) -> str:
    return "shelf" if word == "shelves" else word.removesuffix("s")


# (singular, plural). A thing that was moved is still in the home; one that was taken away left only its place. FORMER and REMOVED
# differ in their words, though both ask for where the thing was in the first visit.
_FORMS: dict[str, tuple[str, str]] = {
    "moved": ("go to the {noun} that was moved", "go to the {noun} that were moved"),
    "former": ("go to where the {noun} used to be", "go to where the {noun} used to be"),
    "moving": ("go to the {noun} that is moving", "go to the {noun} that are moving"),
    "stable": ("go to the {noun} that stayed in place", "go to the {noun} that stayed in place"),
    "appeared": ("go to the {noun} that was not here before", "go to the {noun} that were not here before"),
    "removed": ("go to where the {noun} was before it was taken away", "go to where the {noun} were before they were taken away"),
}

RELATIONS: tuple[str, ...] = tuple(_FORMS)


def sentence(relation: str, noun: str) -> str:
    """Return the canonical surface form of a query: ("former", "vase") -> "go to where the vase used to be".

    No two pairs share a sentence. ValueError for an unknown relation or an empty noun.
    """
    if relation not in _FORMS:
        raise ValueError(f"{relation!r} is not a change relation; the relations are {', '.join(_FORMS)}")
    if not noun.strip():
        raise ValueError("the noun of a sentence is empty")
    return _FORMS[relation][is_plural(noun)].format(noun=noun)
