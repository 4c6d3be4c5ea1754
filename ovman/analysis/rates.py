"""Success rates over episodes, per relation and over all, each with an interval and the name of what that interval is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import fmean
from typing import TypeVar

import numpy as np

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome, is_expectation
from ovman.analysis.statistics import poisson_binomial, wilson_interval
from ovman.records.task import Relation

ALL = "all"

Outcome = TypeVar("Outcome", bound=StaticOutcome | EmbodiedOutcome)


class Interval(StrEnum):
    """What the numbers beside a rate are.

    WILSON: Wilson's score interval of a rate over n episodes. Runs of the same episodes under several seeds are no further
    episodes: the rate is their mean, and the interval is as wide as for one pass. POISSON_BINOMIAL: for the expectation over a
    stochastic pick, which is no count of successes: the central range in which the rate of one realised pass over these very
    episodes falls, of a run drawn at random where there are several.
    """

    WILSON = "wilson"
    POISSON_BINOMIAL = "poisson_binomial"


@dataclass(frozen=True, slots=True)
class Rate:
    """The success of one arm on one relation, or on ``all``.

    n: episodes. seeds: of an embodied arm, or runs of a static one. trials: n times seeds. successes: their count, or its
    expectation (a float) for a stochastic pick. rate: successes over trials, in [0, 1]; low, high: the interval at
    ``confidence``. spl: the mean of Eq. 5 for embodied arms, None for static ones; it has no interval, being neither a count nor
    an expectation of one. least, greatest: the rate of the worst and of the best seed, None where there is one.
    """

    arm: str
    relation: str
    n: int
    seeds: int
    trials: int
    successes: float
    rate: float
    low: float
    high: float
    interval: Interval
    confidence: float
    spl: float | None = None
    least: float | None = None
    greatest: float | None = None


def static_rates(outcomes: Sequence[StaticOutcome], confidence: float) -> list[Rate]:
    """The rates of every static arm: by arm in the order of the outcomes, then by relation in the order of the task, then all."""
    return [
        static_rate(arm, relation, group, confidence)
        for arm, of_arm in by_arm(outcomes).items()
        for relation, group in by_relation(of_arm)
    ]


def static_rate(arm: str, relation: str, group: Sequence[StaticOutcome], confidence: float) -> Rate:
    """The rate of one arm over a group of episodes, which is not empty."""
    expected = any(map(is_expectation, group))
    interval = expected_range([[o.success for o in run] for run in by_seed(group).values()], confidence) if expected else None
    return _rate(arm, relation, group, interval, confidence)


def embodied_rates(outcomes: Sequence[EmbodiedOutcome], confidence: float) -> list[Rate]:
    """The rates of every embodied arm, means over its seeds; ordered as ``static_rates`` orders them."""
    return [
        embodied_rate(arm, relation, group, confidence)
        for arm, of_arm in by_arm(outcomes).items()
        for relation, group in by_relation(of_arm)
    ]


def embodied_rate(arm: str, relation: str, group: Sequence[EmbodiedOutcome], confidence: float) -> Rate:
    """The rate of one arm over a group of episodes under all its seeds; the group is not empty."""
    return _rate(arm, relation, group, None, confidence, math.fsum(outcome.spl for outcome in group) / len(group))


def by_arm(outcomes: Iterable[Outcome]) -> dict[str, list[Outcome]]:
    """The outcomes of each arm, arms in the order in which they come."""
    arms: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        arms.setdefault(outcome.arm, []).append(outcome)
    return arms


def by_relation(outcomes: Sequence[Outcome]) -> list[tuple[str, list[Outcome]]]:
    """The outcomes of each relation that has some, in the order of the task, and then "all" of them."""
    parts: list[tuple[str, list[Outcome]]] = [
        (relation.value, [o for o in outcomes if o.relation is relation]) for relation in Relation
    ]
    return [*((relation, group) for relation, group in parts if group), (ALL, list(outcomes))]


def by_seed(outcomes: Iterable[Outcome]) -> dict[int, list[Outcome]]:
    """The outcomes under each seed, seeds in ascending order."""
    seeds: dict[int, list[Outcome]] = {}
    for outcome in sorted(outcomes, key=lambda outcome: outcome.seed):
        seeds.setdefault(outcome.seed, []).append(outcome)
    return seeds


def chances(outcomes: Mapping[str, StaticOutcome | EmbodiedOutcome]) -> dict[str, tuple[float, float]]:
    """The means of 1/n and of 1/m by relation, and over all. outcomes: one an episode.

    n: the instances of the category; m: the changes of the kind that defines an episode, its own included.
    """
    if not outcomes:
        return {}
    return {
        relation: (fmean(1.0 / outcome.instances for outcome in group), fmean(1.0 / outcome.alike for outcome in group))
        for relation, group in by_relation([*outcomes.values()])
    }


def poisson_binomial_range(probabilities: Sequence[float], confidence: float) -> tuple[float, float]:
    """Central range (low, high) of the rate of independent trials with these probabilities (n,), n >= 1, exact.

    The realised rate lies below low, or above high, with probability at most (1 - confidence) / 2 each. low <= mean <= high up
    to the spacing 1 / n of the rates that can be realised.
    """
    return expected_range([probabilities], confidence)


def expected_range(runs: Sequence[Sequence[float]], confidence: float) -> tuple[float, float]:
    """``poisson_binomial_range`` of one realised pass under one of several runs over the same n episodes, drawn at random.

    runs: the probabilities (n,) of each run. Runs add no episodes, so the range does not narrow with their number.
    """
    n, outside = len(runs[0]), (1.0 - confidence) / 2.0
    distribution = np.mean([poisson_binomial(probabilities) for probabilities in runs], axis=0)
    # From the far end inwards, so that small tails are added before large ones.
    tails = [*np.minimum(np.cumsum(distribution[::-1])[::-1], 1.0).tolist(), 0.0]
    tails[0] = 1.0
    low = max(k for k, at_least in enumerate(tails) if at_least >= 1.0 - outside)
    high = min(k for k, more in enumerate(tails[1:]) if more <= outside)
    return low / n, high / n


def _rate(
    arm: str,
    relation: str,
    group: Sequence[StaticOutcome | EmbodiedOutcome],
    interval: tuple[float, float] | None,
    confidence: float,
    spl: float | None = None,
) -> Rate:
    total = math.fsum(outcome.success for outcome in group)
    seeds = [math.fsum(outcome.success for outcome in run) / len(run) for run in by_seed(group).values()]
    n = len({outcome.episode for outcome in group})
    low, high = interval or wilson_interval(total / len(seeds), n, confidence)
    return Rate(
        arm=arm,
        relation=relation,
        n=n,
        seeds=len(seeds),
        trials=len(group),
        successes=total,
        rate=total / len(group),
        low=low,
        high=high,
        interval=Interval.POISSON_BINOMIAL if interval else Interval.WILSON,
        confidence=confidence,
        spl=spl,
        least=min(seeds) if len(seeds) > 1 else None,
        greatest=max(seeds) if len(seeds) > 1 else None,
    )
