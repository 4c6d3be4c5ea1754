"""Intervals and tests for rates on paired episodes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import NormalDist

import numpy as np


def wilson_interval(successes: float, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return Wilson's score interval (low, high) of a rate, without continuity correction.

    Source: Wilson, J. Am. Stat. Assoc. 22 (1927).

    Args:
        successes: A count, or the mean of the counts of several passes over the same trials.
        trials: At least 1 and at least `successes`.
        confidence: Between 0 and 1.
    """
    rate, z = successes / trials, NormalDist().inv_cdf((1.0 + confidence) / 2.0)
    shrunk = z * z / trials
    centre = (rate + shrunk / 2.0) / (1.0 + shrunk)
    half = math.sqrt(shrunk * (rate * (1.0 - rate) + shrunk / 4.0)) / (1.0 + shrunk)
    # At the ends the bound is the rate itself, which the last bit of a subtraction would miss.
    return 0.0 if successes == 0 else centre - half, 1.0 if successes == trials else centre + half


def mcnemar_exact(wins: int, losses: int) -> float:
    """Return the two-sided p of the exact McNemar test on discordant pairs; 1 without any.

    Source: McNemar, Psychometrika 12 (1947), with the exact binomial distribution.
    """
    pairs = wins + losses
    outer = sum(math.comb(pairs, k) for k in range(min(wins, losses) + 1))
    return min(1.0, 2 * outer / (1 << pairs))


def compare_paired(ours: Iterable[float], theirs: Iterable[float]) -> tuple[int, int, float]:
    """Return the wins, the losses and the p of `mcnemar_exact` of successes on the same episodes, in one order."""
    pairs = list(zip(ours, theirs, strict=True))
    wins, losses = sum(a > b for a, b in pairs), sum(a < b for a, b in pairs)
    return wins, losses, mcnemar_exact(wins, losses)


def auroc(positive: Sequence[float], negative: Sequence[float]) -> float:
    """Return the probability that a score of `positive` exceeds one of `negative`, ties counting one half.

    The area under the ROC curve, exact from the ranks of all scores; NaN if either is empty. Source: Hanley and McNeil,
    Radiology 143 (1982).
    """
    scores = np.concatenate([np.asarray(positive, np.float64), np.asarray(negative, np.float64)])
    if np.isnan(scores).any():
        raise ValueError("a score is not a number")
    n, m = len(positive), len(negative)
    if not n or not m:
        return math.nan
    values, place, counts = np.unique(scores, return_inverse=True, return_counts=True)
    # Twice the mean rank of each value: whole numbers, so that no order of summation changes the result.
    twice = 2 * np.cumsum(counts) - counts + 1
    return float((int(twice[place[:n]].sum()) - n * (n + 1)) / (2 * n * m))


def poisson_binomial(probabilities: Sequence[float]) -> np.ndarray:
    """Return P[X = k] for k = 0 .. n, float64 (n + 1,), of X successes in independent trials with probabilities (n,).

    Convolved one trial at a time. Nothing is subtracted, so each term keeps its relative precision however small it is; scipy's
    survival function is 1 - P[X < k], which is noise below 1e-16.
    """
    distribution = np.ones(1)
    for probability in probabilities:
        distribution = np.append(distribution * (1.0 - probability), 0.0) + np.append(0.0, distribution * probability)
    return distribution


def poisson_binomial_tail(probabilities: Sequence[float], successes: int) -> float:
    """Return P[X >= successes] for X as in `poisson_binomial`, precise far out in the tail.

    Source: the paper's test of a realised agent against the single-visit arm.
    """
    distribution = poisson_binomial(probabilities)
    return 1.0 if successes <= 0 else min(1.0, math.fsum(distribution[successes:]))


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return Holm's step-down adjusted p-values of a family of tests, in the order given.

    Source: Holm, Scand. J. Stat. 6 (1979).
    """
    ranked = np.argsort(p_values)
    multiples = np.asarray(p_values)[ranked] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[ranked] = np.minimum(np.maximum.accumulate(multiples), 1.0)
    return tuple(adjusted.tolist())
