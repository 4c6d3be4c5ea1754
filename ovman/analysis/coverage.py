"""What an agent that says how sure it is would reach if it answered only where it is surest, for each split."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.controls import Judged, judged_splits
from ovman.analysis.outcomes import StaticOutcome
from ovman.analysis.rates import by_arm
from ovman.analysis.statistics import wilson_interval
from ovman.settings import Kind, Settings

STEPS = 20
"""Coverages are the multiples of one over this."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """The episodes of a split of which an arm is surest.

    coverage: their share; answered: their number; least_confidence: the lowest confidence among them; rate: of success among
    them, from low to high.
    """

    split: str
    arm: str
    coverage: float
    answered: int
    least_confidence: float
    successes: int
    rate: float
    low: float
    high: float


def covered(split: str, outcomes: Sequence[StaticOutcome], confidence: float) -> list[Coverage]:
    """The rows of one pass of an arm, from the least coverage to all. Of equally sure answers the first in the order of the ids.

    confidence: of the intervals.
    """
    surest = sorted(outcomes, key=lambda one: (-_sure(one), one.episode))
    rows = []
    for step in range(1, STEPS + 1):
        chosen = surest[: math.ceil(step / STEPS * len(surest))]
        successes = sum(one.success > 0 for one in chosen)
        low, high = wilson_interval(successes, len(chosen), confidence)
        least = _sure(chosen[-1])
        rows.append(
            Coverage(split, chosen[0].arm, step / STEPS, len(chosen), least, successes, successes / len(chosen), low, high)
        )
    return rows


def _sure(outcome: StaticOutcome) -> float:
    return 0.0 if outcome.confidence is None else outcome.confidence


def of_split(judged: Judged, constants: Settings) -> list[Coverage]:
    """The first run of every agent that says how sure it is, controls and agents without a part left out.

    constants: arms, evaluation.confidence.
    """
    if judged.kind is not Kind.STATIC:
        return []
    rows = []
    for name, outcomes in by_arm(frames.read_rows(judged.outcomes, StaticOutcome)).items():
        arm = constants.arms.get(name)
        if arm is None or arm.control or arm.ablates is not None or all(one.confidence is None for one in outcomes):
            continue
        first = [one for one in outcomes if one.seed == outcomes[0].seed]
        rows += covered(judged.split, first, constants.evaluation.confidence)
    return rows


def run(rates: Sequence[Path], outcomes: Sequence[Path], constants: Settings, output: Path) -> None:
    """Write the rows of all splits in the order of the files, which is the same for both. constants: as of ``of_split``."""
    rows = [row for one in judged_splits(rates, outcomes) for row in of_split(one, constants)]
    frames.write(output, Coverage, rows)
