"""Arm against arm on each split: the pairs that are tested on every split, over all relations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.controls import Judged, judged_splits
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import ALL
from ovman.analysis.significance import Method, significance
from ovman.settings import Kind, Settings


@dataclass(frozen=True, slots=True)
class SplitComparison:
    """One pair of arms on one split over all relations, under one seed; the rest as of `Comparison`."""

    split: str
    kind: Kind
    title: str
    arm: str
    baseline: str
    seed: int
    n: int
    successes: int
    baseline_successes: float
    wins: float
    losses: float
    test: Method
    p: float


def compared(judged: Judged, constants: Settings) -> list[SplitComparison]:
    """The pairs that are tested on every split and whose arms have outcomes on this one, by pair and seed.

    constants: comparisons.pairs. ValueError as of `significance`.
    """
    static: list[StaticOutcome] = []
    embodied: list[EmbodiedOutcome] = []
    if judged.kind is Kind.STATIC:
        static = frames.read_rows(judged.outcomes, StaticOutcome)
    else:
        embodied = frames.read_rows(judged.outcomes, EmbodiedOutcome)
    pairs = (pair for pair in constants.comparisons.pairs.values() if pair.every_split)
    rows, _ = significance(static, embodied, pairs)
    return [
        SplitComparison(
            judged.split, judged.kind, row.title, row.arm, row.baseline, row.seed, row.n, row.successes, row.baseline_successes,
            row.wins, row.losses, row.test, row.p,
        )
        for row in rows
        if row.relation == ALL
    ]  # fmt: skip


def run(rates: Sequence[Path], outcomes: Sequence[Path], constants: Settings, output: Path) -> None:
    """Write the rows of all splits, in the order of the files, which is the same for both. constants, errors: ``compared``."""
    rows = [row for one in judged_splits(rates, outcomes) for row in compared(one, constants)]
    frames.write(output, SplitComparison, rows)
