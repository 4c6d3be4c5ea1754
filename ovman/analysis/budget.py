"""The error budget: what each rung of the two-visit agent gains over the one below it (the paper's Fig. diag a)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

from ovman.analysis.rates import Rate
from ovman.analysis.significance import Comparison
from ovman.analysis.statistics import mcnemar_exact

ANSWER_GIVEN = "answer given"
"""Title of the highest rung, the answer itself, which needs no arm."""


@dataclass(frozen=True, slots=True)
class Step:
    """One rung on one relation, or on ``all``. arm: None for the answer given, which succeeds by definition and has no interval.

    gain: rate above that of the rung below; gained, lost: episodes that handing over gains and loses; p: exact two-sided McNemar
    test of the two. All four are None on the lowest rung.
    """

    rung: str
    arm: str | None
    relation: str
    n: int
    successes: int
    rate: float
    low: float | None
    high: float | None
    gain: float | None = None
    gained: int | None = None
    lost: int | None = None
    p: float | None = None


def budget(rates: Iterable[Rate], comparisons: Iterable[Comparison], rungs: Mapping[str, str]) -> list[Step]:
    """The rungs from the lowest, each by relation and over all, and the answer given on top.

    rates: of the static arms; comparisons: what ``significance`` made of the same outcomes, with a test of each rung against the
    one below; rungs: titles by arm, from the lowest rung. Without rates of one of the rungs there is no budget: a step over a
    missing rung would hide which of two handovers it is due to.
    """
    of_arm: dict[str, list[Rate]] = {}
    for rate in rates:
        of_arm.setdefault(rate.arm, []).append(rate)
    if not rungs or any(arm not in of_arm for arm in rungs):
        return []
    tests = {(row.arm, row.baseline, row.relation): row for row in comparisons}
    of_rung = {
        arm: {
            rate.relation: Step(title, arm, rate.relation, rate.n, round(rate.successes), rate.rate, rate.low, rate.high)
            for rate in of_arm[arm]
        }
        for arm, title in rungs.items()
    }
    for lower, upper in pairwise(rungs):
        for relation, step in of_rung[upper].items():
            test = tests[upper, lower, relation]
            gain = step.rate - of_rung[lower][relation].rate
            of_rung[upper][relation] = replace(step, gain=gain, gained=round(test.wins), lost=round(test.losses), p=test.p)
    steps = [step for of_relation in of_rung.values() for step in of_relation.values()]
    return steps + [_answer_given(step) for step in of_rung[next(reversed(of_rung))].values()]


def _answer_given(below: Step) -> Step:
    missing = below.n - below.successes
    return Step(
        rung=ANSWER_GIVEN,
        arm=None,
        relation=below.relation,
        n=below.n,
        successes=below.n,
        rate=1.0,
        low=None,
        high=None,
        gain=1.0 - below.rate,
        gained=missing,
        lost=0,
        p=mcnemar_exact(missing, 0),
    )
