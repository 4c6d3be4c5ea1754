"""Arm against arm on the same episodes: wins, losses and an exact test, by relation and over all."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum

import numpy as np

from ovman.analysis.outcomes import Outcome, group_by, is_expectation
from ovman.analysis.rows import Row
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial_tail, sign_flip_p
from ovman.settings import Pair

COMPARISONS = "title arm baseline seed relation n successes baseline_successes wins losses test p p_holm p_scenes"
PAIRINGS = (
    "title arm baseline arm_run baseline_run relation n successes baseline_successes difference wins losses test p p_holm "
    "p_scenes"
)


class Method(StrEnum):
    """The test of a comparison.

    MCNEMAR: exact, two-sided, on the discordant episodes of two realised arms. POISSON_BINOMIAL: exact, one-sided, the
    probability that the stochastic pick of the baseline succeeds at least as often as the arm did.
    """

    MCNEMAR = "mcnemar"
    POISSON_BINOMIAL = "poisson_binomial"


@dataclass(frozen=True, slots=True)
class Comparison:
    """One pair of arms on one relation, or on "all", under one seed.

    Attributes:
        successes: Counts, as are `wins` and `losses`. If the baseline is a stochastic pick, its successes, the wins and the
            losses are expectations. wins - losses = successes - baseline_successes.
        p_holm: p corrected for the relations of the same pair and seed; None over all.
        p_scenes: p of a test that flips the signs of whole scenes, two-sided; not corrected; None where it was not computed.
    """

    title: str
    arm: str
    baseline: str
    seed: int
    relation: str
    n: int
    successes: int
    baseline_successes: float
    wins: float
    losses: float
    test: Method
    p: float
    p_holm: float | None
    p_scenes: float | None = None


def significance(outcomes: Sequence[Outcome], candidates: Iterable[Pair], stream: str = "") -> list[Comparison]:
    """Compare each pair of arms under each seed that both have: by pair, seed, relation, then all.

    stream: Adds tests by scene, with this random stream.

    Raises:
        ValueError: Two arms share no seed or not the same episodes, or the arm that is tested is a stochastic pick.
    """
    rows = []
    for pair, arm, baseline in _pairs(outcomes, candidates):
        ours, theirs = group_by(arm, "seed"), group_by(baseline, "seed")
        shared = [key for key in ours if key in theirs]
        if not shared:
            raise ValueError(f"{pair.arm} and {pair.baseline} share no seed; make their records again under the same seeds")
        rows += [row for seed in shared for row in compare(pair, seed, ours[seed], theirs[seed], stream)]
    return rows


def pairings(outcomes: Sequence[Outcome], candidates: Iterable[Pair], stream: str = "") -> list[Row]:
    """Compare each run of an arm with each run of its baseline: by pair, the arm's run, the baseline's run, then relation.

    A system that answers differently each time has no run that stands for it, so a claim must hold for the worst pairing.
    `p_holm` is corrected for the relations of one pairing, not for the number of pairings.
    """
    return [
        {**asdict(row), "arm_run": run, "baseline_run": against, "difference": (row.successes - row.baseline_successes) / row.n}
        for pair, arm, baseline in _pairs(outcomes, candidates)
        for run, ours in group_by(arm, "seed").items()
        for against, theirs in group_by(baseline, "seed").items()
        for row in compare(pair, run, ours, theirs, stream)
    ]


def compare(pair: Pair, seed: int, arm: Sequence[Outcome], baseline: Sequence[Outcome], stream: str = "") -> list[Comparison]:
    """Compare one pass of an arm with one pass of its baseline: by relation, corrected for the relations, then over all.

    stream: Adds tests by scene, with this random stream.

    Raises:
        ValueError: The two are not over the same episodes, or the arm is a stochastic pick.
    """
    theirs = {outcome.episode: outcome for outcome in baseline}
    if theirs.keys() != {outcome.episode for outcome in arm}:
        raise ValueError(f"{pair.arm} and {pair.baseline} are not over the same episodes; make their records again")
    *relations, whole = [
        _compare_group(pair, seed, relation, group, [theirs[outcome.episode] for outcome in group], stream)
        for relation, group in group_by(arm, "relation").items()
    ]
    corrected = holm([row.p for row in relations])
    return [replace(row, p_holm=p) for row, p in zip(relations, corrected, strict=True)] + [whole]


def _compare_group(
    pair: Pair, seed: int, relation: str, arm: Sequence[Outcome], baseline: Sequence[Outcome], stream: str
) -> Comparison:
    if any(map(is_expectation, arm)):
        raise ValueError(f"{pair.arm} is a stochastic pick, which no exact test compares with {pair.baseline}; swap the two")
    ours = [bool(outcome.success) for outcome in arm]
    theirs = [float(outcome.success) for outcome in baseline]
    wins = math.fsum(1.0 - p for hit, p in zip(ours, theirs, strict=True) if hit)
    losses = math.fsum(p for hit, p in zip(ours, theirs, strict=True) if not hit)
    if any(map(is_expectation, baseline)):
        test, p = Method.POISSON_BINOMIAL, poisson_binomial_tail(theirs, sum(ours))
    else:
        test, p = Method.MCNEMAR, mcnemar_exact(int(wins), int(losses))
    return Comparison(
        title=pair.name,
        arm=pair.arm,
        baseline=pair.baseline,
        seed=seed,
        relation=relation,
        n=len(ours),
        successes=sum(ours),
        baseline_successes=math.fsum(theirs),
        wins=wins,
        losses=losses,
        test=test,
        p=p,
        p_holm=None,
        p_scenes=sign_flip_p(np.subtract(ours, theirs, dtype=float).tolist(), [one.scene for one in arm], stream)
        if stream
        else None,
    )


def _pairs(outcomes: Sequence[Outcome], candidates: Iterable[Pair]) -> Iterator[tuple[Pair, list[Outcome], list[Outcome]]]:
    """Yield the pairs of which both arms have outcomes."""
    arms = group_by(outcomes, "arm")
    for pair in candidates:
        if pair.arm in arms and pair.baseline in arms:
            yield pair, arms[pair.arm], arms[pair.baseline]
