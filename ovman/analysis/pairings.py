"""Static arms with several runs against each other: every run of the one against every run of the other.

A system that gives other answers each time it runs has no run that is the one to compare. So each pairing of runs is a comparison
of its own, and what is claimed must hold for the worst of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ovman.analysis.comparisons import among
from ovman.analysis.outcomes import StaticOutcome
from ovman.analysis.rates import by_arm, by_seed
from ovman.analysis.significance import Method, family
from ovman.settings import Pair


@dataclass(frozen=True, slots=True)
class Pairing:
    """One run of an arm against one run of its baseline, on one relation or on ``all``.

    difference: of the success rates, the arm's minus the baseline's. All else as in ``ovman.analysis.significance.Comparison``:
    p_holm is corrected for the relations of the same pairing, not for the number of pairings, of which none is picked.
    """

    title: str
    arm: str
    baseline: str
    arm_run: int
    baseline_run: int
    relation: str
    n: int
    successes: int
    baseline_successes: float
    difference: float
    wins: float
    losses: float
    test: Method
    p: float
    p_holm: float | None


def pairings(outcomes: Sequence[StaticOutcome], candidates: Iterable[Pair]) -> tuple[list[Pairing], list[str]]:
    """Every pairing of runs of the candidates whose arms have outcomes, and a line for each pair that was left out.

    Rows are by pair, the arm's run, the baseline's run, then relation and all.

    Raises ValueError where two arms are not over the same episodes, or an arm that is to be tested is a stochastic pick.
    """
    arms = by_arm(outcomes)
    pairs, left_out = among(arms, candidates)
    return [row for pair in pairs for row in _of_pair(pair, arms[pair.arm], arms[pair.baseline])], left_out


def _of_pair(pair: Pair, arm: Sequence[StaticOutcome], baseline: Sequence[StaticOutcome]) -> list[Pairing]:
    return [
        Pairing(
            title=pair.name,
            arm=pair.arm,
            baseline=pair.baseline,
            arm_run=run,
            baseline_run=against,
            relation=row.relation,
            n=row.n,
            successes=row.successes,
            baseline_successes=row.baseline_successes,
            difference=(row.successes - row.baseline_successes) / row.n,
            wins=row.wins,
            losses=row.losses,
            test=row.test,
            p=row.p,
            p_holm=row.p_holm,
        )
        for run, ours in by_seed(arm).items()
        for against, theirs in by_seed(baseline).items()
        for row in family(pair, run, ours, theirs)
    ]
