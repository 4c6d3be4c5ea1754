"""Stops that the success test accepts beside the target's box, though the predicted point fails on the static gate.

Source: "the ObjectNav stop test accepts a prediction that lands 1-2.6 m from the answer point yet within R of the object's box".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import StaticOutcome, is_expectation
from ovman.analysis.rates import ALL, by_arm
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.settings import Arm


@dataclass(frozen=True, slots=True)
class Rescued:
    """One embodied arm that executes a static one's answers, under one seed, on one relation or on ``all``.

    n: episodes. gained: static failures that succeed when executed. rescued: those of them that stop within R of the target's
    box; the others stop within R of the answer, or of its navigable cell, alone. nearest_m, farthest_m: the least and the
    greatest distance from the predicted point to the answer among the rescued, None without any.
    """

    arm: str
    executes: str
    seed: int
    relation: str
    n: int
    gained: int
    rescued: int
    nearest_m: float | None
    farthest_m: float | None


def rescued(static: Sequence[StaticOutcome], runs: Sequence[Score], arms: Sequence[Arm], radius_m: float) -> list[Rescued]:
    """Every embodied arm that executes realised answers, under every seed: by arm in the order of `arms`, then by relation, then
    all. radius_m: R. A stochastic pick has no point that could be rescued."""
    answers = by_arm(static)
    rows = []
    for arm in arms:
        answered = {outcome.episode: outcome for outcome in answers.get(arm.executes or "", ())}
        if arm.executes is None or not answered or any(map(is_expectation, answered.values())):
            continue
        of_arm = [run for run in runs if run.arm == arm.name]
        for seed in sorted({run.seed for run in of_arm}):
            of_seed = [run for run in of_arm if run.seed == seed]
            for relation in (*map(str, Relation), ALL):
                group = [run for run in of_seed if relation in (ALL, str(answered[run.episode].relation))]
                if group:
                    rows.append(_row(arm.name, arm.executes, seed, relation, group, answered, radius_m))
    return rows


def _row(
    arm: str,
    executes: str,
    seed: int,
    relation: str,
    runs: Sequence[Score],
    answered: Mapping[str, StaticOutcome],
    radius_m: float,
) -> Rescued:
    gained = [run for run in runs if run.success and not answered[run.episode].success]
    beside = [run for run in gained if run.box_distance_m is not None and run.box_distance_m <= radius_m]
    metres = [found for run in beside if (found := answered[run.episode].distance_m) is not None]
    return Rescued(
        arm=arm,
        executes=executes,
        seed=seed,
        relation=relation,
        n=len(runs),
        gained=len(gained),
        rescued=len(beside),
        nearest_m=min(metres, default=None),
        farthest_m=max(metres, default=None),
    )
