"""Arm against arm on the same episodes: wins, losses, and a test for each relation and over all (Table significance)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from ovman.analysis.comparisons import among
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome, is_expectation
from ovman.analysis.rates import by_arm, by_relation, by_seed
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial_tail
from ovman.settings import Pair

Outcome = StaticOutcome | EmbodiedOutcome


class Method(StrEnum):
    """MCNEMAR: exact, two-sided, on the discordant episodes of two arms that were both realised. POISSON_BINOMIAL: exact,
    one-sided: how likely the stochastic pick that the baseline stands for succeeds at least as often as the arm did."""

    MCNEMAR = "mcnemar"
    POISSON_BINOMIAL = "poisson_binomial"


@dataclass(frozen=True, slots=True)
class Comparison:
    """One pair of arms on one relation, or on ``all``, under one seed.

    n: episodes. successes, wins, losses: counts; where the baseline is a stochastic pick, baseline_successes, wins and losses are
    their expectations over it. wins - losses = successes - baseline_successes. p_holm: p corrected for the relations of the same
    pair and seed, a family of up to six; None over all, which is one test.
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


def significance(
    static: Sequence[StaticOutcome], embodied: Sequence[EmbodiedOutcome], candidates: Iterable[Pair]
) -> tuple[list[Comparison], list[str]]:
    """Every candidate whose arms have outcomes, by pair, seed, relation, then all; and a line for each that was left out.

    Seeds are paired: arms are compared under each seed that both have. Raises ValueError where both arms have outcomes but share
    no seed or not the same episodes, or where an arm that is to be tested is itself a stochastic pick.
    """
    arms: Mapping[str, Sequence[Outcome]] = {**by_arm(static), **by_arm(embodied)}
    pairs, left_out = among(arms, candidates)
    return [row for pair in pairs for row in _of_pair(pair, arms[pair.arm], arms[pair.baseline])], left_out


def _of_pair(pair: Pair, arm: Sequence[Outcome], baseline: Sequence[Outcome]) -> list[Comparison]:
    seeds = sorted({outcome.seed for outcome in arm} & {outcome.seed for outcome in baseline})
    if not seeds:
        raise ValueError(f"{pair.arm} and {pair.baseline} share no seed; make their records again under the same seeds")
    ours, theirs = by_seed(arm), by_seed(baseline)
    return [row for seed in seeds for row in family(pair, seed, ours[seed], theirs[seed])]


def family(pair: Pair, seed: int, arm: Sequence[Outcome], baseline: Sequence[Outcome]) -> list[Comparison]:
    """One pass of an arm against one pass of its baseline: by relation, corrected for the relations, then all.

    seed: what the rows are marked with. Raises ValueError where the two are not over the same episodes, or where the arm is
    itself a stochastic pick.
    """
    theirs = {outcome.episode: outcome for outcome in baseline}
    if theirs.keys() != {outcome.episode for outcome in arm}:
        raise ValueError(f"{pair.arm} and {pair.baseline} are not over the same episodes; make their records again")
    *relations, whole = [
        _compare(pair, seed, relation, group, [theirs[outcome.episode] for outcome in group])
        for relation, group in by_relation(arm)
    ]
    corrected = holm([row.p for row in relations])
    return [replace(row, p_holm=p) for row, p in zip(relations, corrected, strict=True)] + [whole]


def _compare(pair: Pair, seed: int, relation: str, arm: Sequence[Outcome], baseline: Sequence[Outcome]) -> Comparison:
    if any(map(is_expectation, arm)):
        raise ValueError(f"{pair.arm} is a stochastic pick, which no exact test sets against {pair.baseline}")
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
    )
