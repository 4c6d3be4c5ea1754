"""The noun of a category."""

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

_PLURAL = frozenset({"blinds", "boots", "curtains"})

_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|[0-9]+")


def noun(category: str) -> str:
    """The noun phrase of an AI2-THOR category, without article: "HousePlant" -> "house plant", "TVStand" -> "TV stand".

    Works for any name in CamelCase; abbreviations keep their capitals. Distinct for the 118 categories of the iTHOR floor plans.
    Raises ValueError for a name without letters.
    """
    if category in _SPOKEN:
        return _SPOKEN[category]
    words = _WORD.findall(category)
    if not words:
        raise ValueError(f"{category!r} is not the name of a category")
    return " ".join(word if len(word) > 1 and word.isupper() else word.lower() for word in words)


def is_plural(noun_phrase: str) -> bool:
    """Whether one object goes by a plural noun: "the curtains were moved"."""
    return noun_phrase in _PLURAL
