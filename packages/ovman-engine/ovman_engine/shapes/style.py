"""Reproducible choices: every number of an asset's form or finish is drawn from a hash of its name, not from a stream.

A stream would change all later choices when one is added; a hash of (key, what is chosen) does not.
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
        return low + (high - low) * self.fraction(what)

    def whole(self, what: str, low: int, high: int) -> int:
        """An integer from low to high, both included."""
        return low + self.integer(what) % (high - low + 1)

    def chance(self, what: str, probability: float) -> bool:
        return self.fraction(what) < probability

    def choice(self, what: str, options: Sequence[Option]) -> Option:
        return options[self.integer(what) % len(options)]
