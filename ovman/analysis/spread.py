"""How far apart the seeds of an arm lie: its success in each single pass over the episodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import by_arm, by_relation, by_seed
from ovman.settings import Kind


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

    A static arm with one run answers the same under every seed; a drive depends on the seed.
    """
    several = [o for of_arm in by_arm(static).values() if len(by_seed(of_arm)) > 1 for o in of_arm]
    return [*_of_kind(Kind.STATIC, several), *_of_kind(Kind.EMBODIED, embodied)]


def _of_kind(kind: Kind, outcomes: Sequence[StaticOutcome | EmbodiedOutcome]) -> list[Pass]:
    return [
        Pass(kind, arm, relation, seed, len(run), total := math.fsum(o.success for o in run), total / len(run))
        for arm, of_arm in by_arm(outcomes).items()
        for relation, group in by_relation(of_arm)
        for seed, run in by_seed(group).items()
    ]
