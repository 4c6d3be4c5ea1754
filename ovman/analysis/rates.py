"""Success rates of any grouping of outcomes, each with an interval and the name of that interval."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import fmean

import numpy as np

from ovman.analysis.outcomes import Outcome, group_by, groups, is_expectation
from ovman.analysis.rows import Row
from ovman.analysis.statistics import bootstrap_interval, design_effect, poisson_binomial, wilson_interval

RATES = (
    "arm relation n seeds trials successes rate low high interval confidence spl least greatest "
    "scenes scene_low scene_high design_effect"
)


class Interval(StrEnum):
    """The meaning of the interval of a rate.

    WILSON: Wilson's score interval over n episodes. Several seeds run the same episodes, so the rate is their mean and the
    interval is as wide as for one pass. POISSON_BINOMIAL: for the expectation over a stochastic pick, the central range of the
    rate of one realised pass over these episodes, of a run drawn at random if there are several.
    """

    WILSON = "wilson"
    POISSON_BINOMIAL = "poisson_binomial"


@dataclass(frozen=True, slots=True)
class Rate:
    """The success of one arm on one relation, or on "all".

    Attributes:
        n: Episodes. `seeds`: of an embodied arm, or runs of a static one. `trials`: n times seeds.
        successes: Their count; an expectation for a stochastic pick.
        rate: Successes over trials. `low`, `high`: its interval at `confidence`.
        spl: The mean of Eq. 5 of an embodied arm.
        least: The rate of the worst seed, and `greatest` of the best; None if there is one seed.
        scenes: Their number. `scene_low`, `scene_high`: the interval when whole scenes are resampled. `design_effect`: n divided
            by it is the effective sample size. None where they were not computed or do not exist, as at a rate of 0 or 1.
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
    scenes: int | None = None
    scene_low: float | None = None
    scene_high: float | None = None
    design_effect: float | None = None


def rates(outcomes: Iterable[Outcome], by: Sequence[str], confidence: float) -> list[Row]:
    """Return one row per group of outcomes: the columns of `by`, then those of `Rate` from `n` to `greatest`.

    by: Columns to group by, such as ("arm", "relation"); "relation" adds a group of all relations.
    """
    return [{**dict(zip(by, key, strict=True)), **_rate(group, confidence)} for key, group in groups(outcomes, *by).items()]


def arm_rates(outcomes: Iterable[Outcome], confidence: float, stream: str = "") -> list[Rate]:
    """Compute the rate of each arm by relation and over all. stream: adds statistics by scene, with this random stream."""
    by = ("arm", "relation")
    return [
        Rate(
            **dict(zip(by, key, strict=True)),
            **_rate(group, confidence),
            **(_spread(group, confidence, stream) if stream else {}),
        )
        for key, group in groups(outcomes, *by).items()
    ]


def _spread(group: Sequence[Outcome], confidence: float, stream: str) -> Row:
    """Return the statistics by scene. An episode counts once, with its mean over the seeds."""
    of_episode = group_by(group, "episode").values()
    values = [math.fsum(outcome.success for outcome in runs) / len(runs) for runs in of_episode]
    scenes = [runs[0].scene for runs in of_episode]
    low, high = bootstrap_interval(values, scenes, stream, confidence) or (None, None)
    effect = design_effect(values, scenes)
    return {"scenes": len({*scenes}), "scene_low": low, "scene_high": high, "design_effect": effect}


def _rate(group: Sequence[Outcome], confidence: float) -> Row:
    runs = [[outcome.success for outcome in run] for run in group_by(group, "seed").values()]
    n, total = len({outcome.episode for outcome in group}), math.fsum(outcome.success for outcome in group)
    expected = any(map(is_expectation, group))
    low, high = expected_range(runs, confidence) if expected else wilson_interval(total / len(runs), n, confidence)
    passes = [math.fsum(run) / len(run) for run in runs]
    spl = [outcome.spl for outcome in group if outcome.spl is not None]
    return {
        "n": n,
        "seeds": len(runs),
        "trials": len(group),
        "successes": total,
        "rate": total / len(group),
        "low": low,
        "high": high,
        "interval": Interval.POISSON_BINOMIAL if expected else Interval.WILSON,
        "confidence": confidence,
        "spl": math.fsum(spl) / len(spl) if spl else None,
        "least": min(passes) if len(runs) > 1 else None,
        "greatest": max(passes) if len(runs) > 1 else None,
    }


def expected_range(runs: Sequence[Sequence[float]], confidence: float) -> tuple[float, float]:
    """Return the central range of the rate of one realised pass, under one of several runs drawn at random; exact.

    The realised rate lies below the range, or above it, with probability at most (1 - confidence) / 2 each. Runs add no episodes,
    so the range does not narrow with their number.

    Args:
        runs: The success probabilities (n,) of each run over the same n episodes.
        confidence: Probability that the range covers.
    """
    n, outside = len(runs[0]), (1.0 - confidence) / 2.0
    distribution = np.mean([poisson_binomial(probabilities) for probabilities in runs], axis=0)
    # From the far end inwards, so that small tails are added before large ones.
    tails = [*np.minimum(np.cumsum(distribution[::-1])[::-1], 1.0).tolist(), 0.0]
    tails[0] = 1.0
    low = max(k for k, at_least in enumerate(tails) if at_least >= 1.0 - outside)
    high = min(k for k, more in enumerate(tails[1:]) if more <= outside)
    return low / n, high / n


def chances(outcomes: Iterable[Outcome]) -> dict[str, tuple[float, float]]:
    """Return the means of 1/n and 1/m over the episodes by relation and over all.

    n counts the instances of the category, m the changes of the kind that defines an episode, its own included.
    """
    episodes = {outcome.episode: outcome for outcome in outcomes}
    return {
        str(relation): (fmean(1.0 / outcome.instances for outcome in group), fmean(1.0 / outcome.alike for outcome in group))
        for relation, group in group_by(episodes.values(), "relation").items()
    }
