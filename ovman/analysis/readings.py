"""Grounding handed over, by each reading of "ground truth over its own map objects", beside an arm's own grounding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import StaticOutcome, is_expectation
from ovman.analysis.rates import by_arm, by_relation, by_seed, static_rate
from ovman.analysis.statistics import mcnemar_exact
from ovman.settings import Arm, Source

OWN, POSITIONS = "own", "positions"


@dataclass(frozen=True, slots=True)
class HandedOver:
    """The success of one arm on one relation, or on ``all``.

    map: what it reads; grounding: OWN, the reading by which its grounding is handed over, or POSITIONS. n, successes, rate, low,
    high: as of ``Rate``. gained, lost: episodes on which it succeeds and the map's first arm does not, and the other way round;
    p: exact two-sided McNemar test of them. None for the first arm, an expectation, or an arm of several runs.
    """

    map: str
    grounding: str
    arm: str
    relation: str
    n: int
    successes: float
    rate: float
    low: float
    high: float
    gained: int | None = None
    lost: int | None = None
    p: float | None = None


def grounding_of(arm: Arm) -> str:
    """OWN, the reading by which the grounding is handed over, or POSITIONS."""
    if arm.positions is Source.HANDED:
        return POSITIONS
    return str(arm.reading) if arm.grounding is Source.HANDED else OWN


def readings(
    outcomes: Sequence[StaticOutcome], arms: Sequence[Arm], maps: Mapping[str, str], confidence: float
) -> list[HandedOver]:
    """The rows of the arms of `maps`, which says by arm what it reads, in its order. Arms without outcomes have none."""
    of_arm, entries = by_arm(outcomes), {arm.name: arm for arm in arms}
    first: dict[str, Sequence[StaticOutcome]] = {}
    rows = []
    for name, title in maps.items():
        if name not in of_arm:
            continue
        baseline = first.setdefault(title, of_arm[name])
        for relation, group in by_relation(of_arm[name]):
            rate = static_rate(name, relation, group, confidence)
            wins, losses, p = (None, None, None) if baseline is of_arm[name] else _against(group, baseline)
            rows.append(
                HandedOver(
                    title, grounding_of(entries[name]), name, relation, rate.n, rate.successes, rate.rate, rate.low, rate.high,
                    wins, losses, p,
                )
            )  # fmt: skip
    return rows


def _against(
    group: Sequence[StaticOutcome], baseline: Sequence[StaticOutcome]
) -> tuple[int, int, float] | tuple[None, None, None]:
    if any(map(is_expectation, (*group, *baseline))) or len(by_seed(group)) > 1 or len(by_seed(baseline)) > 1:
        return None, None, None
    was = {outcome.episode: outcome.success for outcome in baseline}
    wins = sum(outcome.success > was[outcome.episode] for outcome in group)
    losses = sum(outcome.success < was[outcome.episode] for outcome in group)
    return wins, losses, mcnemar_exact(wins, losses)
