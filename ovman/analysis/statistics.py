"""Intervals and tests for rates on paired episodes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.stats import binom, norm


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson's score interval of a rate, without continuity correction: (low, high) in [0, 1].

    Raises ValueError unless 0 <= successes <= trials, trials >= 1 and 0 < confidence < 1.
    Source: Wilson, J. Am. Stat. Assoc. 22 (1927).
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"{successes} successes of {trials} trials are no rate")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"a confidence lies between 0 and 1, not at {confidence}")
    z = float(norm.ppf(0.5 + confidence / 2.0))
    rate = successes / trials
    shrink = 1.0 + z * z / trials
    middle = (rate + z * z / (2.0 * trials)) / shrink
    half = z / shrink * math.sqrt(rate * (1.0 - rate) / trials + z * z / (4.0 * trials * trials))
    # At the ends the bound is the rate itself, which the last bit of the subtraction would miss.
    low = 0.0 if successes == 0 else middle - half
    high = 1.0 if successes == trials else middle + half
    return low, high


def mcnemar_exact(wins: int, losses: int) -> float:
    """Two-sided p of the exact McNemar test: `wins` and `losses` are the discordant pairs. 1 where there are none.

    Raises ValueError for a negative count.
    """
    if wins < 0 or losses < 0:
        raise ValueError(f"{wins} wins and {losses} losses: a count is at least 0")
    return min(1.0, 2.0 * float(binom.cdf(min(wins, losses), wins + losses, 0.5)))


def poisson_binomial_tail(probabilities: Sequence[float], successes: int) -> float:
    """P[X >= successes] for X the number of successes of independent trials with the given probabilities (n,), exact.

    The distribution is built one trial at a time. No term is ever subtracted, so that small tails keep their relative precision.
    Raises ValueError for a probability outside [0, 1].
    """
    distribution = np.ones(1)
    for probability in probabilities:
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"{probability} is no probability")
        distribution = np.append(distribution * (1.0 - probability), 0.0) + np.append(0.0, distribution * probability)
    return 1.0 if successes <= 0 else min(1.0, math.fsum(distribution[successes:]))


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Holm's step-down adjusted p-values for a family of tests, in the order given.

    Raises ValueError for a value outside [0, 1]. Source: Holm, Scand. J. Stat. 6 (1979).
    """
    for p in p_values:
        if not 0.0 <= p <= 1.0:
            raise ValueError(f"{p} is no p-value")
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    for rank, k in enumerate(sorted(range(len(p_values)), key=lambda k: p_values[k])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[k]))
        adjusted[k] = largest
    return tuple(adjusted)
