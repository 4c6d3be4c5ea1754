"""The error budget: what each rung of the two-visit agent gains over the one below it (the paper's Fig. diag a)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from ovman.analysis.comparisons import ANSWER_GIVEN, RUNGS
from ovman.analysis.rates import Rate
from ovman.analysis.significance import Comparison
from ovman.analysis.statistics import mcnemar_exact


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


def budget(rates: Iterable[Rate], comparisons: Iterable[Comparison]) -> list[Step]:
    """The rungs from the lowest, each by relation and over all, and the answer given on top.

    rates: of the static arms; comparisons: what ``significance`` made of the same outcomes. Without rates of one of the rungs
    there is no budget, as a step over a missing rung would hide which of two handovers it is due to.
    """
    of_arm: dict[str, list[Rate]] = {}
    for rate in rates:
        of_arm.setdefault(rate.arm, []).append(rate)
    if any(rung.arm not in of_arm for rung in RUNGS):
        return []
    tests = {(row.arm, row.baseline, row.relation): row for row in comparisons}
    steps: list[Step] = []
    below: dict[str, Step] = {}
    for lower, rung in zip((None, *RUNGS), RUNGS, strict=False):
        here = {
            rate.relation: Step(
                rung.title, rung.arm, rate.relation, rate.n, round(rate.successes), rate.rate, rate.low, rate.high
            )
            for rate in of_arm[rung.arm]
        }
        if lower:
            for relation, step in here.items():
                test = tests[rung.arm, lower.arm, relation]
                gain = step.rate - below[relation].rate
                here[relation] = replace(step, gain=gain, gained=round(test.wins), lost=round(test.losses), p=test.p)
        steps += here.values()
        below = here
    return steps + [_answer_given(step) for step in below.values()]


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
