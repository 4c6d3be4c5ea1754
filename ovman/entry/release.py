"""The files of a release that an entry is judged by and set beside."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ovman.analysis.outcomes import StaticOutcome
from ovman.analysis.rates import Rate
from ovman.analysis.rows import read_rows
from ovman.models.settings import MAIN, Kind, Settings, splits_of

ROOT = Path(__file__).parents[2]
"""The checkout."""
CONFIG, DATA = ROOT / "config.yaml", ROOT / "data" / "ovman-embedded-v2"


class EntryError(ValueError):
    """What stands in the way of a score; the message is one line with the remedy."""


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

    def static(self, split: str) -> tuple[list[Rate], list[StaticOutcome]]:
        """Rates and outcomes, on a split, of the reference arm and of the static controls that the release has there.

        Both are in the order of the settings, the reference arm first; empty where the release has no metrics of the split.
        """
        name = str(Kind.STATIC) if split == MAIN else split
        files = [self.directory / "metrics" / f"{name}_{part}.csv" for part in ("rates", "outcomes")]
        if not all(path.is_file() for path in files):
            return [], []
        comparisons, arms = self.settings.comparisons, self.settings.arms
        controls = [one for one in comparisons.controls if one in arms and arms[one].control and arms[one].kind is Kind.STATIC]
        place = {arm: number for number, arm in enumerate(dict.fromkeys([comparisons.agent, *controls]))}
        rates, outcomes = read_rows(files[0], Rate, place), read_rows(files[1], StaticOutcome, place)
        return sorted(rates, key=lambda row: place[row.arm]), sorted(outcomes, key=lambda row: place[row.arm])
