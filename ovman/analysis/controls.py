"""The stage "controls": success by relation of controls and of the agents that they are set beside, for each split."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Interval, Rate, chances
from ovman.settings import MAIN, Kind, Settings


@dataclass(frozen=True, slots=True)
class Controlled:
    """One arm of comparisons.controls on one relation of a split, or on ``all``: its rate as in the split's own rates.

    control: whether it is a control. chance: the mean of 1/n_i over the episodes, n_i the instances of an episode's category.
    chance_of_change: the mean of 1/m_i, m_i the changes of the kind that defines an episode, its own included.
    least, greatest: of the seeds or runs.
    """

    split: str
    kind: Kind
    arm: str
    control: bool
    relation: str
    n: int
    rate: float
    low: float
    high: float
    interval: Interval
    chance: float
    chance_of_change: float
    spl: float | None
    least: float | None
    greatest: float | None


@dataclass(frozen=True, slots=True)
class Judged:
    """The files of one kind of arms on one split: their rates, and their outcomes of the episodes."""

    split: str
    kind: Kind
    rates: Path
    outcomes: Path

    @classmethod
    def of(cls, rates: Path, outcomes: Path) -> Judged:
        """By the names of the files: those of the benchmark's own split bear the kind, those of another its name, and behind it
        the kind where that is embodied."""
        name = rates.stem.removesuffix("_rates")
        if name in set(Kind):
            return cls(MAIN, Kind(name), rates, outcomes)
        split = name.removesuffix(f"_{Kind.EMBODIED}")
        return cls(split, Kind.STATIC if split == name else Kind.EMBODIED, rates, outcomes)


def controlled(judged: Judged, constants: Settings) -> list[Controlled]:
    """The arms of comparisons.controls that have rates, in the order of the settings, then by relation.

    constants: arms, comparisons.controls. Raises ValueError in one line where rates are of other episodes than the outcomes.
    """
    kind: type[StaticOutcome] | type[EmbodiedOutcome] = StaticOutcome if judged.kind is Kind.STATIC else EmbodiedOutcome
    outcomes: Sequence[StaticOutcome | EmbodiedOutcome] = frames.read_rows(judged.outcomes, kind)
    chance = chances({outcome.episode: outcome for outcome in outcomes})
    rates: dict[str, list[Rate]] = {}
    for rate in frames.read_rows(judged.rates, Rate):
        rates.setdefault(rate.arm, []).append(rate)
    names = [name for name in constants.comparisons.controls if name in rates and name in constants.arms]
    try:
        return [_row(judged, constants.arms[name].control, rate, chance[rate.relation]) for name in names for rate in rates[name]]
    except KeyError as relation:
        raise ValueError(f"{judged.rates}: {relation} is not in {judged.outcomes}; make the metrics again") from None


def _row(judged: Judged, control: bool, rate: Rate, chance: tuple[float, float]) -> Controlled:
    return Controlled(
        split=judged.split,
        kind=judged.kind,
        arm=rate.arm,
        control=control,
        relation=rate.relation,
        n=rate.n,
        rate=rate.rate,
        low=rate.low,
        high=rate.high,
        interval=rate.interval,
        chance=chance[0],
        chance_of_change=chance[1],
        spl=rate.spl,
        least=rate.least,
        greatest=rate.greatest,
    )


def judged_splits(rates: Sequence[Path], outcomes: Sequence[Path]) -> list[Judged]:
    """The splits of the files, of which each rates file has its outcomes file at the same place."""
    return [Judged.of(*files) for files in zip(rates, outcomes, strict=True)]


def run(rates: Sequence[Path], outcomes: Sequence[Path], constants: Settings, output: Path) -> None:
    """Write the rows of all splits in the order of the files, which is the same for both. constants, errors: ``controlled``."""
    judged = judged_splits(rates, outcomes)
    frames.write(output, Controlled, [row for one in judged for row in controlled(one, constants)])
