"""The files of a release that an entry is judged by and set beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Rate
from ovman.analysis.rows import read_rows
from ovman.analysis.significance import Outcome
from ovman.entry.errors import EntryError
from ovman.models.run import Score
from ovman.models.settings import MAIN, Kind, Settings, splits_of


@dataclass(frozen=True, slots=True)
class Release:
    """A folder of released files, and the settings that name its splits and arms."""

    directory: Path
    settings: Settings

    def episodes(self, split: str) -> Path:
        """The episodes of a split. EntryError for a name that is no split's, and where the release has none of it."""
        if split not in (names := splits_of(self.settings.splits)):
            raise EntryError(f"--split: {split} is no split; write one of {', '.join(names)}")
        path = self.directory / "episodes" / f"{split}.jsonl"
        if not path.is_file():
            raise EntryError(f"{path}: the release has no episodes of the split {split}; name a release with --release")
        return path

    def split_of(self, episodes: bytes) -> str | None:
        """The split whose released file of episodes has these bytes, None where there is none."""
        files = {split: self.directory / "episodes" / f"{split}.jsonl" for split in splits_of(self.settings.splits)}
        return next((split for split, file in files.items() if file.is_file() and file.read_bytes() == episodes), None)

    def runs(self, arm: str, split: str) -> list[Score]:
        """The judged runs of an arm on a split, empty where the release has none."""
        folder = self.directory / "runs"
        files = sorted((folder / arm).glob("seed*/*.jsonl")) if split == MAIN else [folder / split / f"{arm}.jsonl"]
        return [run for file in files if file.is_file() for run in Score.read(file)]

    def references(self, kind: Kind) -> frozenset[str]:
        """The reference agent: `comparisons.agent`, or the embodied arms that drive to its answers."""
        agent = self.settings.comparisons.agent
        of = {name for name, arm in self.settings.arms.items() if arm.kind is kind and arm.executes == agent}
        return frozenset({agent} if kind is Kind.STATIC else of)

    def of_kind(self, kind: Kind, split: str) -> tuple[list[Rate], Sequence[Outcome]]:
        """Rates and outcomes, on a split, of the arms of a kind that are the reference agent or controls.

        In the order of the settings, the reference agent first; empty where the release has no metrics of that kind on the split.
        """
        name = {MAIN: str(kind)}.get(split, split if kind is Kind.STATIC else f"{split}_{kind}")
        files = [self.directory / "metrics" / f"{name}_{part}.csv" for part in ("rates", "outcomes")]
        if not all(path.is_file() for path in files):
            return [], []
        arms = self.settings.arms
        controls = [one for one in self.settings.comparisons.controls if one in arms and arms[one].control]
        named = [*sorted(self.references(kind)), *(one for one in controls if arms[one].kind is kind)]
        place = {arm: number for number, arm in enumerate(named)}
        row: type[StaticOutcome] | type[EmbodiedOutcome] = StaticOutcome if kind is Kind.STATIC else EmbodiedOutcome
        outcomes: Sequence[Outcome] = read_rows(files[1], row, place)
        rates = read_rows(files[0], Rate, place)
        return sorted(rates, key=lambda rate: place[rate.arm]), sorted(outcomes, key=lambda outcome: place[outcome.arm])
