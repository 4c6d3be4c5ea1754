"""An agent's success on the task that it was made for, beside its success on this one: what the anti-shortcut rule takes away.

CoW is made to reach any instance of a category. Here it must reach the one that the relation selects, and where the answer is a
place of the past, no instance at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import EmbodiedOutcome
from ovman.analysis.rates import by_arm, by_relation, by_seed
from ovman.analysis.statistics import mcnemar_exact


@dataclass(frozen=True, slots=True)
class OwnTask:
    """One embodied arm under one seed, on one relation or on ``all``: the same n runs under two tests.

    own_successes, own_rate: on the agent's own task; successes, rate: on this one (Eq. 4). gap: own_rate - rate. only_own,
    only_here: runs that succeed under one of the tests alone; p: exact two-sided McNemar test on the two.
    """

    arm: str
    seed: int
    relation: str
    n: int
    own_successes: int
    own_rate: float
    successes: int
    rate: float
    gap: float
    only_own: int
    only_here: int
    p: float


def own_task(outcomes: Sequence[EmbodiedOutcome]) -> list[OwnTask]:
    """Every arm whose runs were judged on a task of their own: by arm, seed, relation, then all.

    Raises ValueError for an arm of which some runs were and others were not.
    """
    rows = []
    for arm, of_arm in by_arm(outcomes).items():
        judged = [outcome for outcome in of_arm if outcome.own_success is not None]
        if not judged:
            continue
        if len(judged) < len(of_arm):
            raise ValueError(
                f"{arm}: {len(of_arm) - len(judged)} of {len(of_arm)} runs have no verdict on its own task; judge them all again"
            )
        for seed, runs in by_seed(of_arm).items():
            rows += [_row(arm, seed, relation, group) for relation, group in by_relation(runs)]
    return rows


def _row(arm: str, seed: int, relation: str, runs: Sequence[EmbodiedOutcome]) -> OwnTask:
    n = len(runs)
    own, here = sum(bool(run.own_success) for run in runs), sum(run.success for run in runs)
    only_own = sum(bool(run.own_success) and not run.success for run in runs)
    only_here = sum(run.success and not run.own_success for run in runs)
    return OwnTask(
        arm=arm,
        seed=seed,
        relation=relation,
        n=n,
        own_successes=own,
        own_rate=own / n,
        successes=here,
        rate=here / n,
        gap=(own - here) / n,
        only_own=only_own,
        only_here=only_here,
        p=mcnemar_exact(only_own, only_here),
    )
