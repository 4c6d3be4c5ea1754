"""Success rates over episodes, per relation and over all, each with an interval and the name of what that interval is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.statistics import poisson_binomial_tail, wilson_interval
from ovman.task import Relation

ALL = "all"


class Interval(StrEnum):
    """What the numbers beside a rate are.

    WILSON: Wilson's score interval of successes in trials. An arm with several seeds pools them: its trials are episodes times
    seeds, which the interval takes as independent though the seeds share their episodes, so it is about the spread of single
    runs and narrower than one for new episodes would be. POISSON_BINOMIAL: for the expectation over a stochastic pick, which is
    no count of successes: the central range in which the rate of one realised pass over these very episodes falls.
    """

    WILSON = "wilson"
    POISSON_BINOMIAL = "poisson_binomial"


@dataclass(frozen=True, slots=True)
class Rate:
    """The success of one arm on one relation, or on ``all``.

    n: episodes. trials: n times seeds. successes: their count, or its expectation (a float) for a stochastic pick. rate:
    successes over trials, in [0, 1]; low, high: the interval at ``confidence``. spl: the mean of Eq. 5 for embodied arms, None
    for static ones; it has no interval, being neither a count nor an expectation of one.
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


def static_rates(outcomes: Sequence[StaticOutcome], confidence: float) -> list[Rate]:
    """The rates of every static arm: by arm in the order of the outcomes, then by relation in the order of the task, then all."""

    def rate(arm: str, relation: str, group: Sequence[StaticOutcome]) -> Rate:
        probabilities = [outcome.success for outcome in group]
        expected = any(outcome.outcome == "expected" for outcome in group)
        interval = poisson_binomial_range(probabilities, confidence) if expected else None
        return _rate(arm, relation, group, probabilities, interval, confidence)

    return _grouped(outcomes, rate)


def embodied_rates(outcomes: Sequence[EmbodiedOutcome], confidence: float) -> list[Rate]:
    """The rates of every embodied arm, its seeds pooled; ordered as ``static_rates`` orders them."""

    def rate(arm: str, relation: str, group: Sequence[EmbodiedOutcome]) -> Rate:
        spl = sum(outcome.spl for outcome in group) / len(group)
        return _rate(arm, relation, group, [float(outcome.success) for outcome in group], None, confidence, spl)

    return _grouped(outcomes, rate)


def poisson_binomial_range(probabilities: Sequence[float], confidence: float) -> tuple[float, float]:
    """Central range (low, high) of the rate of independent trials with these probabilities (n,), n >= 1, exact.

    The realised rate lies below low, or above high, with probability at most (1 - confidence) / 2 each. low <= mean <= high up
    to the spacing 1 / n of the rates that can be realised.
    """
    n, outside = len(probabilities), (1.0 - confidence) / 2.0
    tails = [poisson_binomial_tail(probabilities, successes) for successes in range(n + 1)] + [0.0]
    low = max(k for k in range(n + 1) if tails[k] >= 1.0 - outside)
    high = min(k for k in range(n + 1) if tails[k + 1] <= outside)
    return low / n, high / n


def _grouped(outcomes: Sequence, rate: Callable[[str, str, list], Rate]) -> list[Rate]:
    rates = []
    for arm in dict.fromkeys(outcome.arm for outcome in outcomes):
        of_arm = [outcome for outcome in outcomes if outcome.arm == arm]
        for relation in Relation:
            group = [outcome for outcome in of_arm if outcome.relation is relation]
            if group:
                rates.append(rate(arm, relation.value, group))
        rates.append(rate(arm, ALL, of_arm))
    return rates


def _rate(
    arm: str,
    relation: str,
    group: Sequence[StaticOutcome | EmbodiedOutcome],
    successes: Iterable[float],
    interval: tuple[float, float] | None,
    confidence: float,
    spl: float | None = None,
) -> Rate:
    total = sum(successes)
    low, high = interval or wilson_interval(round(total), len(group), confidence)
    return Rate(
        arm=arm,
        relation=relation,
        n=len({outcome.episode for outcome in group}),
        seeds=len({outcome.seed for outcome in group}),
        trials=len(group),
        successes=total,
        rate=total / len(group),
        low=low,
        high=high,
        interval=Interval.POISSON_BINOMIAL if interval else Interval.WILSON,
        confidence=confidence,
        spl=spl,
    )
