"""Which of the pairs of arms in the settings can be compared: those of which both arms have outcomes."""

from __future__ import annotations

from collections.abc import Iterable

from ovman.settings import Pair


def among(arms: Iterable[str], candidates: Iterable[Pair]) -> tuple[list[Pair], list[str]]:
    """The candidates of which both arms are among `arms`, and a line for each of the others that says which arm is missing."""
    there = set(arms)
    pairs, left_out = [], []
    for pair in candidates:
        lacking = [name for name in (pair.arm, pair.baseline) if name not in there]
        if not lacking:
            pairs.append(pair)
        else:
            left_out.append(f"not compared: {pair.name}; there is no arm {' and no '.join(lacking)}")
    return pairs, left_out
