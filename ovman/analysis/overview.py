"""Who reaches what on which split: success over all relations, on paper and driving, in one row an entry of the settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.controls import Judged, judged_splits
from ovman.analysis.rates import ALL, Rate
from ovman.settings import Kind, Settings


@dataclass(frozen=True, slots=True)
class Overview:
    """An entry of comparisons.overview on a split: the rate of its arm of a kind over all relations, as in the split's own rates.

    control: whether the arm is a control. spl: of an embodied arm.
    """

    title: str
    split: str
    kind: Kind
    arm: str
    control: bool
    n: int
    rate: float
    low: float
    high: float
    spl: float | None


def overview(judged: Sequence[Judged], constants: Settings) -> list[Overview]:
    """The entries in the order of the settings, each on every split and in every kind in which its arm has rates.

    constants: arms, comparisons.overview.
    """
    rates = {
        (one.split, one.kind): {rate.arm: rate for rate in frames.read_rows(one.rates, Rate) if rate.relation == ALL}
        for one in judged
    }
    return [
        Overview(title, split, kind, arm, constants.arms[arm].control, of.n, of.rate, of.low, of.high, of.spl)
        for title, entry in constants.comparisons.overview.items()
        for (split, kind), by_arm in rates.items()
        for arm in (entry.static if kind is Kind.STATIC else entry.embodied,)
        if arm in constants.arms and (of := by_arm.get(arm)) is not None
    ]


def run(rates: Sequence[Path], outcomes: Sequence[Path], constants: Settings, output: Path) -> None:
    """Write the rows of all splits of the files. constants: as of ``overview``."""
    frames.write(output, Overview, overview(judged_splits(rates, outcomes), constants))
