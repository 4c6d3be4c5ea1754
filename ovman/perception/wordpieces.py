"""Split phrases into BERT's word pieces (uncased), as its vocabulary numbers them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

import numpy as np

FIRST, LAST, UNKNOWN = "[CLS]", "[SEP]", "[UNK]"
MORE = "##"
"""Begins a piece that is not a word's first."""
MOST = 128
"""Most pieces of a phrase, the first and the last included."""


class WordPieces:
    """A vocabulary of word pieces; a piece's number is its place."""

    def __init__(self, pieces: Sequence[str]) -> None:
        self._number = {piece: number for number, piece in enumerate(pieces)}

    def numbers(self, phrase: str) -> np.ndarray:
        """Return the numbers (1, N) int64 of the pieces of a phrase."""
        plain = "".join(sign for sign in unicodedata.normalize("NFD", phrase.lower()) if unicodedata.category(sign) != "Mn")
        pieces = [piece for word in re.findall(r"[^\W_]+|[^\w\s]|_", plain) for piece in self._split(word)]
        return np.array([[self._number[piece] for piece in (FIRST, *pieces[: MOST - 2], LAST)]], np.int64)

    def _split(self, word: str) -> list[str]:
        """Return the longest known pieces of a word from left to right."""
        pieces: list[str] = []
        while word:
            start = MORE if pieces else ""
            end = next((end for end in range(len(word), 0, -1) if start + word[:end] in self._number), 0)
            if not end:
                return [UNKNOWN]
            pieces.append(start + word[:end])
            word = word[end:]
        return pieces
