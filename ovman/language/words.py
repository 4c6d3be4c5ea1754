"""A sentence as words: lower case, no punctuation, no contractions, and the nouns of the vocabulary found in it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from ovman.language.number import other_number
from ovman.language.vocabulary import all_nouns

_NOT = re.compile(r"\b(is|are|was|were|has|have|had|do|does|did|would|could|should)(?:n't|nt)\b")
_CONTRACTED = ((re.compile(r"\bwon'?t\b"), "will not"), (re.compile(r"\b(?:can't|cannot|cant)\b"), "can not")) + (
    (_NOT, r"\1 not"),
    (re.compile(r"\bain't\b"), "is not"),
    (
        re.compile(r"'(ve|re|ll|m|d)\b"),
        lambda found: {"ve": " have", "re": " are", "ll": " will", "m": " am", "d": " would"}[found[1]],
    ),
    (re.compile(r"\b(it|there|that|where|what|who|he|she|here|let)'s\b"), r"\1 is"),
    # Of a noun it may be "is", "has" or the possessor, which what follows tells.
    (re.compile(r"'s\b"), " 's"),
    (re.compile(r"s'(?=\s|$)"), "s 's"),
)


def words(sentence: str) -> tuple[str, ...]:
    """The words of a sentence. "The T.V. isn't Tom's!" -> ("the", "tv", "is", "not", "tom", "'s")."""
    text = unicodedata.normalize("NFKC", sentence).casefold()
    text = re.sub("[\u2018\u2019\u02bc`\u00b4]", "'", text)
    text = re.sub(r"\b(?:[a-z]\.){2,}", lambda found: found[0].replace(".", ""), text)
    for pattern, plain in _CONTRACTED:
        text = pattern.sub(plain, text)
    return tuple(re.findall(r"'s(?!\w)|\w+", text))


@dataclass(frozen=True, slots=True)
class Mention:
    """A noun of the vocabulary in a sentence: its words are those from start up to end."""

    noun: str
    start: int
    end: int


def mentions(said: Sequence[str]) -> tuple[Mention, ...]:
    """The nouns in the words of a sentence from left to right, the longest where one is part of another.

    Words may be joined or split ("houseplant", "arm chair") and the noun may be in the other number.
    """
    return tuple(_mentions(said))


def _mentions(said: Sequence[str]) -> Iterator[Mention]:
    lexicon, longest = _lexicon()
    start = 0
    while start < len(said):
        ends = range(min(start + longest, len(said)), start, -1)
        spellings = ((joint.join(said[start:end]), end) for end in ends for joint in (" ", ""))
        found = next((Mention(lexicon[spelling], start, end) for spelling, end in spellings if spelling in lexicon), None)
        if found:
            yield found
        start = found.end if found else start + 1


@cache
def _lexicon() -> tuple[Mapping[str, str], int]:
    """The nouns by how they are spelled, with and without spaces, and the most words that a noun is split into."""
    nouns = all_nouns()
    spelled: dict[str, str] = {}
    # What the vocabulary has itself ("washbasin" and "wash basin" are two nouns of it) goes before what is made of it.
    for joint in (" ", ""):
        for said in (lambda noun: noun, other_number):
            for noun in nouns:
                spelled.setdefault(joint.join(words(said(noun))), noun)
    # "footstool" may be said "foot stool", one word more than the vocabulary has.
    return MappingProxyType(spelled), 1 + max(len(words(noun)) for noun in nouns)
