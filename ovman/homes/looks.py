"""Which assets look different in the engine's pictures, from the table that training/looks.py makes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path


@cache
def _alike() -> frozenset[frozenset[str]]:
    table = json.loads(Path(__file__).with_name("looks.json").read_text(encoding="utf-8"))
    return frozenset(frozenset(pair) for pairs in table.values() for pair in pairs)


def looks_different(first: str, second: str) -> bool:
    """Return whether two assets of one category and split can be told apart in pictures."""
    return first != second and frozenset((first, second)) not in _alike()
