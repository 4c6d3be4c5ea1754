"""What executing an answer costs and gains: SPL given success, and what becomes of a static arm's verdicts when they are run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome, is_expectation
from ovman.analysis.rates import by_arm, by_relation
from ovman.analysis.statistics import mcnemar_exact
from ovman.settings import Arm


@dataclass(frozen=True, slots=True)
class Navigation:
    """One embodied arm under one seed, on one relation or on ``all``.

    n: episodes. successes, sr, spl: of its runs (Eq. 4 and 5). spl_given_success: mean SPL of the successful runs, None without
    any. executes: the static arm whose answers it drives to, or None; static_successes: that arm's (an expectation
    for a stochastic pick). lost: its successes that fail when executed; gained: its failures that succeed, because the stop test
    also accepts a stop near the target's box or the navigable cell; p: exact two-sided McNemar test of one against the other.
    The last three are None for an arm that executes none or a stochastic pick.
    """

    arm: str
    seed: int
    relation: str
    n: int
    successes: int
    sr: float
    spl: float
    spl_given_success: float | None
    executes: str | None
    static_successes: float | None
    lost: int | None
    gained: int | None
    p: float | None


def navigation(static: Sequence[StaticOutcome], embodied: Sequence[EmbodiedOutcome], arms: Sequence[Arm]) -> list[Navigation]:
    """Every embodied arm under every seed: by arm and seed in the order of the outcomes, then by relation, then all.

    arms: which embodied arm executes which static one. Raises ValueError where a static arm that is executed has answers under
    several seeds, of which none could be said to be the one executed.
    """
    executes = {arm.name: arm.executes for arm in arms}
    answers = by_arm(static)
    for name, outcomes in answers.items():
        if name in executes.values() and len({outcome.seed for outcome in outcomes}) > 1:
            raise ValueError(f"{name} has answers under several seeds; an arm that is executed has one answer an episode")
    rows = []
    for name, runs in by_arm(embodied).items():
        executed = {outcome.episode: outcome for outcome in answers.get(executes[name] or "", ())}
        for seed in dict.fromkeys(run.seed for run in runs):
            for relation, group in by_relation([run for run in runs if run.seed == seed]):
                rows.append(_row(name, executes[name], seed, relation, group, executed))
    return rows


def _row(
    arm: str,
    executes: str | None,
    seed: int,
    relation: str,
    runs: Sequence[EmbodiedOutcome],
    executed: Mapping[str, StaticOutcome],
) -> Navigation:
    successful = [run.spl for run in runs if run.success]
    answered = [executed[run.episode] for run in runs] if executed else []
    realised = bool(answered) and not any(map(is_expectation, answered))
    lost = gained = p = None
    if realised:
        lost = sum(bool(answer.success) and not run.success for answer, run in zip(answered, runs, strict=True))
        gained = sum(run.success and not answer.success for answer, run in zip(answered, runs, strict=True))
        p = mcnemar_exact(gained, lost)
    return Navigation(
        arm=arm,
        seed=seed,
        relation=relation,
        n=len(runs),
        successes=len(successful),
        sr=len(successful) / len(runs),
        spl=math.fsum(run.spl for run in runs) / len(runs),
        spl_given_success=math.fsum(successful) / len(successful) if successful else None,
        executes=executes,
        static_successes=math.fsum(outcome.success for outcome in answered) if answered else None,
        lost=lost,
        gained=gained,
        p=p,
    )
