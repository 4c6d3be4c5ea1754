"""Weights of the cues of appearance, fitted to tell pairs of map objects of the same instance from pairs of different ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ovman.analysis.statistics import auroc


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """P pairs of map objects of one category, one of each visit.

    unlike (P,) by cue: how unlike they are; same (P,): whether both show one instance.
    """

    unlike: Mapping[str, np.ndarray]
    same: np.ndarray

    @property
    def counts(self) -> tuple[int, int]:
        """How many are the same, and how many are not."""
        same = int(self.same.sum())
        return same, len(self.same) - same


@dataclass(frozen=True, slots=True)
class Weights:
    """by_cue: shares, which sum to 1. scale: by cue what its disagreement is multiplied by, so that it is as large as the first
    cue's on average over the pairs of the fit: shares then leave appearance as heavy against distance as it was.
    """

    by_cue: Mapping[str, float]
    scale: Mapping[str, float]

    def combined(self, unlike: Mapping[str, np.ndarray]) -> np.ndarray:
        """The weighted sum of disagreements of any one shape."""
        total: np.ndarray = np.sum([share * self.scale[cue] * unlike[cue] for cue, share in self.by_cue.items()], axis=0)
        return total


def alone(cue: str) -> Weights:
    """All weight on one cue, as it is."""
    return Weights({cue: 1.0}, {cue: 1.0})


def separation(pairs: Pairs, weights: Weights) -> float:
    """AUROC of the combined cues: how probably a pair of one instance is less unlike than a pair of two. NaN without either."""
    unlike = -weights.combined(pairs.unlike)
    return auroc(unlike[pairs.same], unlike[~pairs.same])


def fitted(pairs: Pairs, cues: Sequence[str], step: float, least_pairs: int, equal_scales: bool = True) -> Weights:
    """The weights of a grid of shares by `step` with the highest AUROC; of equal ones those with most weight on the first cues.

    equal_scales: whether cues are scaled to the size of the first, or taken as they are. All weight is on the first cue where
    there are fewer than least_pairs pairs of either kind.
    """
    if min(pairs.counts) < least_pairs or len(cues) == 1:
        return Weights({cue: float(cue == cues[0]) for cue in cues}, dict.fromkeys(cues, 1.0))
    size = {cue: float(pairs.unlike[cue].mean()) for cue in cues}
    comparable = equal_scales and all(value > 0 for value in size.values())
    scale = {cue: size[cues[0]] / size[cue] if comparable else 1.0 for cue in cues}
    every = [Weights(dict(zip(cues, shares, strict=True)), scale) for shares in grid(len(cues), step)]
    return max(every, key=lambda weights: (separation(pairs, weights), *weights.by_cue.values()))


def grid(cues: int, step: float) -> list[tuple[float, ...]]:
    """All shares of so many cues in multiples of about `step`, a whole part of 1, that sum to 1."""
    parts = math.ceil(1 / step - 1e-9)
    free = product(range(parts + 1), repeat=cues - 1)
    return [(*(k / parts for k in some), (parts - sum(some)) / parts) for some in free if sum(some) <= parts]
