from __future__ import annotations

import re

import pytest

from ovman.language import cues
from ovman.language.grammar import Grammar

FRAGMENTS = {"was": "was | were", "adv": "really | just"}


def matched(pattern: str, said: str) -> list[str]:
    words = said.split()
    return [" ".join(words[start:end]) for _, start, end in Grammar(FRAGMENTS, [pattern]).matches(words)]


@pytest.mark.parametrize(("pattern", "said", "found"), [
    ("<was> moved", "it was moved", ["was moved"]),
    ("<was> <adv>* moved", "it was really just moved", ["was really just moved"]),
    ("a b?", "a b a", ["a b", "a"]),
    ("( a | a b ) b?", "a b b", ["a b b"]),
    ("( a b )* c", "a b a b c c", ["a b a b c", "c"]),
    ("<adv>*", "it just", ["just"]),
    ("a | b c", "b a", ["a"]),
    ("( a? )* b", "a a b", ["a a b"]),
])  # fmt: skip
def test_longest_matches(pattern, said, found):
    assert matched(pattern, said) == found


@pytest.mark.parametrize(("pattern", "error"), [("( a", ValueError), ("a )", ValueError), ("<none>", KeyError)])
def test_a_pattern_that_is_none_is_refused(pattern, error):
    with pytest.raises(error):
        Grammar(FRAGMENTS, [pattern])


def test_longest_pattern_wins_and_the_first_of_equals():
    grammar = Grammar({}, ["new", "new place", "new | old"])
    assert list(grammar.matches(["a", "new", "place", "and", "new"])) == [(1, 1, 3), (0, 4, 5)]


def test_every_fragment_of_the_cues_is_used():
    patterns = [*cues._FRAGMENTS.values(), *(pattern for _, pattern in cues._PATTERNS)]
    assert set(cues._FRAGMENTS) == {name for pattern in patterns for name in re.findall(r"<(\w+)>", pattern)}
