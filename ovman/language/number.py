"""Which noun phrases of the vocabulary are plural, and the other number of a noun."""

from __future__ import annotations

import re

from ovman.language.noun import is_plural as is_plural_category

# Beside the plural nouns of the categories themselves: synonyms, by their last word.
_PLURAL_HEADS = frozenset({"drapes", "keys", "shades", "shelves", "shoes", "tissues"})


def is_plural(noun_phrase: str) -> bool:
    """Whether one object goes by a plural noun, synonyms included: "the drapes were moved", but "the pair of boots was moved"."""
    words = noun_phrase.split()
    return "of" not in words and (words[-1] in _PLURAL_HEADS or is_plural_category(words[-1]))


def other_number(noun_phrase: str) -> str:
    """The regular plural of a singular noun phrase, or the singular of a plural one; its head is the word before "of" or "to".

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
