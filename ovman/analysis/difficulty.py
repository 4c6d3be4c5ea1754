"""Static success by the number of instances of the queried category and by scene (the paper's Fig. difficulty)."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from ovman.analysis.outcomes import StaticOutcome
from ovman.analysis.rates import Interval, by_arm, static_rate

MANY = 4
"""Categories with at least so many instances are one group."""


class By(StrEnum):
    """What episodes are grouped by."""

    INSTANCES = "instances"
    SCENE = "scene"


@dataclass(frozen=True, slots=True)
class Difficulty:
    """The rate of one arm over one group of n episodes; low, high, interval, confidence: as in ``ovman.analysis.rates.Rate``."""

    by: By
    group: str
    arm: str
    n: int
    successes: float
    rate: float
    low: float
    high: float
    interval: Interval
    confidence: float


def difficulty(outcomes: Sequence[StaticOutcome], confidence: float) -> list[Difficulty]:
    """Every group with every static arm: instances 2, 3, "4+", then the scenes by the number in their name; arms as they come."""
    rows = []
    for by, key in KEYS.items():
        for group in sorted({key(outcome) for outcome in outcomes}, key=natural):
            for arm, of_arm in by_arm(outcomes).items():
                rate = static_rate(arm, group, [outcome for outcome in of_arm if key(outcome) == group], confidence)
                rows.append(
                    Difficulty(
                        by=by,
                        group=group,
                        arm=arm,
                        n=rate.n,
                        successes=rate.successes,
                        rate=rate.rate,
                        low=rate.low,
                        high=rate.high,
                        interval=rate.interval,
                        confidence=confidence,
                    )
                )
    return rows


def _instances(outcome: StaticOutcome) -> str:
    return str(outcome.instances) if outcome.instances < MANY else f"{MANY}+"


KEYS: dict[By, Callable[[StaticOutcome], str]] = {By.INSTANCES: _instances, By.SCENE: lambda outcome: outcome.scene}


def natural(name: str) -> tuple[int, str]:
    """Where a name comes in an order by the number in it."""
    number = re.search(r"\d+", name)
    return (int(number.group()) if number else 0, name)
