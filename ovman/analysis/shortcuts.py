"""What recognising the category alone is worth: every arm beside the chance of 1/n, and on crowded and uncrowded episodes.

Source: "an agent that recognises the category but not which of the n instances the relation selects is at chance 1/n".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import Case, EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import by_arm, by_relation
from ovman.settings import Kind


@dataclass(frozen=True, slots=True)
class Shortcut:
    """One arm on one relation, or on ``all``: n episodes, its success over them and over its seeds or runs.

    chance: the mean of 1/n_i, n_i the instances of an episode's category; excess: rate - chance. crowded: how many of the
    episodes have another instance of the category within the success radius of the answer, in the visit that the answer belongs
    to or in the second; crowded_rate, uncrowded_rate: the success on these and on the others, None where there are none.
    """

    kind: Kind
    arm: str
    relation: str
    n: int
    chance: float
    rate: float
    excess: float
    crowded: int
    crowded_rate: float | None
    uncrowded_rate: float | None


def shortcuts(
    cases: Sequence[Case], static: Sequence[StaticOutcome], embodied: Sequence[EmbodiedOutcome], radius_m: float
) -> list[Shortcut]:
    """Every arm on every relation: static arms first, arms as they come, then relations, then all. radius_m: of the success test.

    ValueError for an outcome of an episode that is not among the cases.
    """
    crowded = {case.id: case.neighbour_m is not None and case.neighbour_m <= radius_m for case in cases}
    return [*_of_kind(Kind.STATIC, static, crowded), *_of_kind(Kind.EMBODIED, embodied, crowded)]


def _of_kind(kind: Kind, outcomes: Sequence[StaticOutcome | EmbodiedOutcome], crowded: dict[str, bool]) -> list[Shortcut]:
    if strangers := sorted({outcome.episode for outcome in outcomes} - crowded.keys()):
        raise ValueError(f"{strangers[0]} is not among the episodes; make the records of the arms again")
    return [
        _row(kind, arm, relation, group, crowded)
        for arm, of_arm in by_arm(outcomes).items()
        for relation, group in by_relation(of_arm)
    ]


def _row(
    kind: Kind, arm: str, relation: str, group: Sequence[StaticOutcome | EmbodiedOutcome], crowded: dict[str, bool]
) -> Shortcut:
    episodes = {outcome.episode for outcome in group}
    chance, rate = _mean([1.0 / outcome.instances for outcome in group]), _mean([outcome.success for outcome in group])
    assert chance is not None and rate is not None
    return Shortcut(
        kind=kind,
        arm=arm,
        relation=relation,
        n=len(episodes),
        chance=chance,
        rate=rate,
        excess=rate - chance,
        crowded=sum(crowded[episode] for episode in episodes),
        crowded_rate=_mean([outcome.success for outcome in group if crowded[outcome.episode]]),
        uncrowded_rate=_mean([outcome.success for outcome in group if not crowded[outcome.episode]]),
    )


def _mean(values: Sequence[float]) -> float | None:
    return math.fsum(values) / len(values) if values else None
