"""Patterns over words, and the longest match of each: the notation that ``ovman.language.cues`` is written in.

A pattern is words separated by spaces. "p | q" is either pattern as far as the brackets around them, "( p )", reach; "<name>" is
the fragment of that name; "?" behind a word, a fragment or a closing bracket makes it optional, "*" repeats it. All readings of a
pattern are followed, so that the order of alternatives means nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class _Word:
    word: str


@dataclass(frozen=True, slots=True)
class _Fragment:
    name: str


@dataclass(frozen=True, slots=True)
class _Either:
    """Alternatives, each a sequence of parts."""

    patterns: tuple[tuple[_Part, ...], ...]


@dataclass(frozen=True, slots=True)
class _Part:
    node: _Node
    optional: bool = False
    repeated: bool = False


_Node = _Word | _Fragment | _Either
_Beginning = tuple[frozenset[str], bool]


class Grammar:
    """Named fragments and patterns that refer to them.

    Raises ValueError for a pattern whose brackets do not match, KeyError for an unknown fragment. A fragment must not
    contain itself.
    """

    def __init__(self, fragments: Mapping[str, str], patterns: Sequence[str]) -> None:
        self._fragments = {name: _parsed(pattern) for name, pattern in fragments.items()}
        self._patterns = tuple(_parsed(pattern) for pattern in patterns)
        self._first: dict[str, tuple[int, ...]] = {}
        for node in (*self._fragments.values(), *self._patterns):
            for name in _names(node):
                if name not in self._fragments:
                    raise KeyError(f"unknown fragment <{name}>; name one of {', '.join(self._fragments)}")
        beginnings: dict[str, _Beginning] = {}
        for index, pattern in enumerate(self._patterns):
            for word in self._beginnings(pattern, beginnings)[0]:
                self._first[word] = (*self._first.get(word, ()), index)

    def matches(self, said: Sequence[str]) -> Iterator[tuple[int, int, int]]:
        """(index of the pattern, start, end) of the longest matches from left to right, none of which overlap.

        Of equally long ones the first pattern's; a word that no pattern begins with is passed over.
        """
        reading, start = _Reading(self._fragments, said), 0
        while start < len(said):
            candidates = self._first.get(said[start], ())
            found = ((index, max(reading.ends(self._patterns[index], start), default=start)) for index in candidates)
            index, end = max(found, key=lambda match: match[1], default=(0, start))
            if end > start:
                yield index, start, end
            start = max(end, start + 1)

    def _beginnings(self, node: _Node, known: dict[str, _Beginning]) -> _Beginning:
        """The words that a match of `node` may begin with, and whether it may have no word at all."""
        match node:
            case _Word(word):
                return frozenset({word}), False
            case _Fragment(name):
                if name not in known:
                    known[name] = self._beginnings(self._fragments[name], known)
                return known[name]
            case _Either(patterns):
                words, empty = frozenset[str](), False
                for parts in patterns:
                    for part in parts:
                        found, nothing = self._beginnings(part.node, known)
                        words |= found
                        if not (part.optional or nothing):
                            break
                    else:
                        empty = True
                return words, empty


class _Reading:
    """The matches of one sequence of words, each fragment read once a place."""

    def __init__(self, fragments: Mapping[str, _Either], said: Sequence[str]) -> None:
        self._fragments, self._said = fragments, said
        self._read: dict[tuple[str, int], frozenset[int]] = {}

    def ends(self, node: _Node, start: int) -> frozenset[int]:
        """Where a match of `node` that begins at `start` may end."""
        match node:
            case _Word(word):
                fits = start < len(self._said) and self._said[start] == word
                return frozenset({start + 1}) if fits else frozenset()
            case _Fragment(name):
                if (name, start) not in self._read:
                    self._read[name, start] = self.ends(self._fragments[name], start)
                return self._read[name, start]
            case _Either(patterns):
                return frozenset().union(*(self._sequence(pattern, start) for pattern in patterns))

    def _sequence(self, parts: Sequence[_Part], start: int) -> frozenset[int]:
        reached = frozenset({start})
        for part in parts:
            if not reached:
                break
            passed = frozenset().union(*(self.ends(part.node, at) for at in reached))
            found = passed
            while part.repeated and found:
                found = frozenset().union(*(self.ends(part.node, at) for at in found)) - passed
                passed |= found
            reached = passed | reached if part.optional else passed
        return reached


def _parsed(pattern: str) -> _Either:
    pieces = iter(pattern.replace("|", " | ").split())
    node, closed = _either(pieces, pattern)
    if closed is not None:
        raise ValueError(f"a bracket is closed that was not opened: {pattern!r}")
    return node


def _either(pieces: Iterator[str], pattern: str) -> tuple[_Either, str | None]:
    """The alternatives up to the bracket that closes them, and that bracket; None at the end of the pattern."""
    alternatives: list[list[_Part]] = [[]]
    for piece in pieces:
        if piece in (")", ")?", ")*"):
            return _Either(tuple(map(tuple, alternatives))), piece
        if piece == "|":
            alternatives.append([])
            continue
        body, suffix = (piece[:-1], piece[-1]) if piece[-1] in "?*" else (piece, "")
        node: _Node
        if body == "(":
            node, closing = _either(pieces, pattern)
            if closing is None:
                raise ValueError(f"a bracket is not closed: {pattern!r}")
            suffix = closing[1:]
        elif body.startswith("<") and body.endswith(">"):
            node = _Fragment(body[1:-1])
        else:
            node = _Word(body)
        alternatives[-1].append(_Part(node, optional=suffix != "", repeated=suffix == "*"))
    return _Either(tuple(map(tuple, alternatives))), None


def _names(node: _Node) -> Iterator[str]:
    match node:
        case _Fragment(name):
            yield name
        case _Either(patterns):
            for parts in patterns:
                for part in parts:
                    yield from _names(part.node)
