"""Intervals and tests for rates on paired episodes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import product
from statistics import NormalDist

import numpy as np

from ovman.seeds import generator

RESAMPLES = 2000
"""Resamples of a bootstrap over scenes, and of Kendall's tau."""
FLIPS = 10_000
"""Flips of signs of a randomisation test over scenes, where there are more ways than this."""


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


@cache
def draw_resamples(scenes: int, stream: str) -> np.ndarray:
    """Return how often each scene is drawn in each resample, int64 (RESAMPLES, scenes): as many scenes as there are.

    stream: names the random stream. Tables of one split share it, so that a figure is the same in all of them; splits do not.
    """
    return generator(0, "resamples", stream, scenes).multinomial(scenes, np.full(scenes, 1.0 / scenes), RESAMPLES)


def sum_by_scene(values: Sequence[float], scenes: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums and the numbers of values (n,) by scene, float64 (k,) and int64 (k,)."""
    _, of_scene = np.unique(scenes, return_inverse=True)
    return np.bincount(of_scene, values), np.bincount(of_scene)


def bootstrap_interval(
    values: Sequence[float], scenes: Sequence[str], stream: str, confidence: float = 0.95
) -> tuple[float, float] | None:
    """Return the percentile interval of the mean of values (n,) when whole scenes are resampled.

    None if all scenes have one mean, as at a rate of 0 or 1: resampling then says nothing about the spread.
    Source: Davison and Hinkley, Bootstrap Methods (1997), section 3.8.
    """
    sums, sizes = sum_by_scene(values, scenes)
    if np.ptp(sums / sizes) == 0.0:
        return None
    drawn = draw_resamples(len(sums), stream)
    outside = (1.0 - confidence) / 2.0
    low, high = np.quantile((drawn @ sums) / (drawn @ sizes), [outside, 1.0 - outside])
    return float(low), float(high)


def design_effect(values: Sequence[float], scenes: Sequence[str]) -> float | None:
    """Return the variance of the mean over scenes divided by its variance if the n values were independent.

    n divided by it is the effective sample size. None for values that are all equal, and for one scene.
    Source: Kish, Survey Sampling (1965); the variance of a ratio estimator, linearised.
    """
    sums, sizes = sum_by_scene(values, scenes)
    k, n, mean = len(sums), len(values), float(np.mean(values))
    independent = float(np.var(values)) / n
    if k < 2 or independent <= 0.0:
        return None
    return float(k / (k - 1) * np.sum((sums - mean * sizes) ** 2) / n**2 / independent)


@cache
def _draw_signs(scenes: int, stream: str) -> np.ndarray:
    """Return flips of signs, float64 (flips, scenes): all if there are at most FLIPS, else random ones and the identity."""
    if 2**scenes <= FLIPS:
        return np.array(list(product((1.0, -1.0), repeat=scenes)))
    signs = generator(0, "signs", stream, scenes).choice((1.0, -1.0), (FLIPS, scenes))
    signs[0] = 1.0
    return signs


def sign_flip_p(differences: Sequence[float], scenes: Sequence[str], stream: str) -> float:
    """Return the two-sided p of a test that flips the sign of each scene's summed difference (n,).

    It supposes that scenes, not episodes, are independent. Scenes without a difference do not count. Exact where the ways to
    flip number at most FLIPS. Source: Fisher, The Design of Experiments (1935), section 21.
    """
    sums, _ = sum_by_scene(differences, scenes)
    sums = sums[np.abs(sums) > 1e-12]
    # Rounding must not make a flip that equals the data smaller than the data.
    return float(np.mean(np.abs(_draw_signs(len(sums), stream) @ sums) >= abs(sums.sum()) - 1e-9))
