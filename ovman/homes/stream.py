"""Random draws that stay the same on every processor, Python and NumPy version."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Sequence
from typing import TypeVar

Item = TypeVar("Item")


class Stream:
    """A stream of draws that is named by texts and numbers.

    Python's documentation promises that `random.random` gives the same numbers for the same integer seed in later versions, and
    promises it for no other method. All draws here are made from it.
    """

    def __init__(self, *names: str | int) -> None:
        """Seed the stream by the SHA-256 digest of its names."""
        text = "|".join(map(str, names))
        self._random = random.Random(int.from_bytes(hashlib.sha256(text.encode()).digest(), "big")).random

    def chance(self, probability: float) -> bool:
        """Return True with this probability."""
        return self._random() < probability

    def integer(self, low: int, high: int, step: int = 1) -> int:
        """Return low, low + step, ..., at most `high`, each equally likely. `low` where high < low."""
        return low + step * int(self._random() * (max(high - low, 0) // step + 1))

    def choice(self, items: Sequence[Item], weights: Sequence[float] | None = None) -> Item:
        """Return one of `items`, with probabilities in proportion to `weights`."""
        if weights is None:
            return items[int(self._random() * len(items))]
        point = self._random() * sum(weights)
        for item, weight in zip(items, weights, strict=True):
            point -= weight
            if point < 0:
                return item
        return items[-1]

    def shuffled(self, items: Sequence[Item]) -> list[Item]:
        """Return the items in a random order."""
        out = list(items)
        for k in range(len(out) - 1, 0, -1):
            j = int(self._random() * (k + 1))
            out[k], out[j] = out[j], out[k]
        return out
