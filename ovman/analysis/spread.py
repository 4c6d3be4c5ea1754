"""How far apart the seeds of an arm lie: its success in each single pass over the episodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import by_arm, by_relation, by_seed
from ovman.models.settings import Kind


@dataclass(frozen=True, slots=True)
class Pass:
    """One arm under one seed (of a static arm: in one run), on one relation or on ``all``.

    successes: a count, or its expectation for a stochastic pick; rate: of the n episodes.
    """

    kind: Kind
    arm: str
    relation: str
    seed: int
    n: int
    successes: float
    rate: float


def passes(static: Sequence[StaticOutcome], embodied: Sequence[EmbodiedOutcome]) -> list[Pass]:
    """Static arms with several runs, then every embodied arm: by arm, then relation and all, then seed.

    A static arm with one run answers the same under every seed; what becomes of a drive hangs on the seed.
    """
    rows = []
    for kind, outcomes in ((Kind.STATIC, static), (Kind.EMBODIED, embodied)):
        for arm, of_arm in by_arm(outcomes).items():
            if kind is Kind.STATIC and len(by_seed(of_arm)) == 1:
                continue
            rows += [
                Pass(kind, arm, relation, seed, len(run), total := math.fsum(o.success for o in run), total / len(run))
                for relation, group in by_relation(of_arm)
                for seed, run in by_seed(group).items()
            ]
    return rows
