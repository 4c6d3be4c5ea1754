"""How a static arm fails: one verdict an episode, and how many static successes are lost in navigation (Table taxonomy)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from ovman.analysis.navigation import Navigation
from ovman.analysis.outcomes import StaticOutcome, is_expectation
from ovman.analysis.rates import by_arm, by_relation, by_seed


class Verdict(StrEnum):
    """What became of an episode, in the order of the paper's table. Every episode has exactly one.

    SUCCESS: the point is within R of the answer. ABSTAIN: there is no point. WRONG_INSTANCE: the point is a failure within R of
    another instance of the category, in the visit that the answer belongs to. NEAR_MISS, ELSEWHERE: any other failure, up to or
    beyond the near-miss distance from the answer. A point beside another instance is explained by it however near the answer
    is, so WRONG_INSTANCE goes before the two.
    """

    SUCCESS = "success"
    ABSTAIN = "abstain"
    ELSEWHERE = "elsewhere"
    NEAR_MISS = "near_miss"
    WRONG_INSTANCE = "wrong_instance"


LOST = "lost_in_navigation"
"""A subset of SUCCESS, no sixth verdict: static successes that fail when executed."""


@dataclass(frozen=True, slots=True)
class TaxonomyCount:
    """episodes: how many of the n episodes of a relation (or of ``all``) have the verdict; for ``LOST``, how many of the
    successes the embodied arm lost under the seed. embodied is None for verdicts, which no execution changes; their seed is the
    run of an arm with several runs, and None for one that answers once."""

    arm: str
    verdict: str
    relation: str
    episodes: int
    n: int
    embodied: str | None = None
    seed: int | None = None


def verdict(outcome: StaticOutcome, radius_m: float, near_miss_m: float) -> Verdict:
    """The verdict on one prediction; radius_m is R. Raises ValueError for a stochastic pick, which has no point to look at."""
    if is_expectation(outcome):
        raise ValueError(f"{outcome.arm} is a stochastic pick: {outcome.episode} has a probability, no verdict")
    if outcome.success:
        return Verdict.SUCCESS
    if outcome.distance_m is None:
        return Verdict.ABSTAIN
    if outcome.other_m is not None and outcome.other_m <= radius_m:
        return Verdict.WRONG_INSTANCE
    return Verdict.NEAR_MISS if outcome.distance_m <= near_miss_m else Verdict.ELSEWHERE


def taxonomy(
    outcomes: Sequence[StaticOutcome], navigations: Iterable[Navigation], radius_m: float, near_miss_m: float
) -> list[TaxonomyCount]:
    """The counts of every static arm with realised answers: by arm, run, verdict, relation and all; then what navigation lost.

    Raises AssertionError if the verdicts of a relation do not add up to its episodes.
    """
    lost = [row for row in navigations if row.lost is not None]
    rows = []
    for arm, of_arm in by_arm(outcomes).items():
        if any(map(is_expectation, of_arm)):
            continue
        runs = by_seed(of_arm)
        for seed, run in runs.items():
            rows += _counts(arm, seed if len(runs) > 1 else None, run, radius_m, near_miss_m)
        rows += [
            TaxonomyCount(arm, LOST, row.relation, row.lost or 0, row.n, row.arm, row.seed) for row in lost if row.executes == arm
        ]
    return rows


def _counts(arm: str, seed: int | None, run: Sequence[StaticOutcome], radius_m: float, near_miss_m: float) -> list[TaxonomyCount]:
    groups = by_relation(run)
    counts = {relation: Counter(verdict(o, radius_m, near_miss_m) for o in group) for relation, group in groups}
    for relation, group in groups:
        assert sum(counts[relation][which] for which in Verdict) == len(group), f"{arm}, {relation}: verdicts are no partition"
    return [
        TaxonomyCount(arm, which.value, relation, counts[relation][which], len(group), seed=seed)
        for which in Verdict
        for relation, group in groups
    ]
