"""Reproducible random choices: every number of an asset's form or finish is a hash of its name, not the next of a stream.

In a stream, an added choice would change all later ones; a hash of (key, name of the choice) does not.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

Option = TypeVar("Option")


@dataclass(frozen=True)
class Style:
    """Choices of one asset, named by `key`."""

    key: str

    def fraction(self, what: str) -> float:
        """Uniform in [0, 1)."""
        return self.integer(what) / 2**64

    def integer(self, what: str) -> int:
        """Uniform 64-bit integer."""
        return int.from_bytes(hashlib.blake2b(f"{self.key}|{what}".encode(), digest_size=8).digest(), "big")

    def uniform(self, what: str, low: float, high: float) -> float:
        """Uniform in [low, high)."""
        return low + (high - low) * self.fraction(what)

    def whole(self, what: str, low: int, high: int) -> int:
        """Return an integer from low to high, both included."""
        return low + self.integer(what) % (high - low + 1)

    def chance(self, what: str, probability: float) -> bool:
        """Return true with the given probability."""
        return self.fraction(what) < probability

    def choice(self, what: str, options: Sequence[Option]) -> Option:
        """One of `options`, all equally likely."""
        return options[self.integer(what) % len(options)]
