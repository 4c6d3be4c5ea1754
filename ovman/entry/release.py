"""The files of a release that an entry is judged by and set beside."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis.outcomes import Case, EmbodiedOutcome, StaticOutcome, embodied_outcomes
from ovman.analysis.rates import Rate, embodied_rates
from ovman.analysis.rows import read_rows
from ovman.analysis.significance import Outcome
from ovman.entry.defaults import LEADERBOARD
from ovman.entry.errors import EntryError
from ovman.entry.manifest import FILE, Manifest, read_manifest
from ovman.entry.run_files import read_runs, runs_path
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.settings import MAIN, Kind, Settings


@dataclass(frozen=True, slots=True)
class Release:
    """A folder of released files, and the settings that name its splits and arms."""

    directory: Path
    settings: Settings
    leaderboard: Path = LEADERBOARD

    def episodes(self, split: str) -> Path:
        """The episodes of a split. EntryError for a name that is no split's, and where the release has none of it."""
        if split not in (names := self.settings.splits):
            raise EntryError(f"--split: {split} is no split; write one of {', '.join(names)}")
        path = self.directory / "episodes" / f"{split}.jsonl"
        if not path.is_file():
            raise EntryError(f"{path}: the release has no episodes of the split {split}; name a release with --release")
        return path

    def split_of(self, episodes: bytes) -> str | None:
        """The split whose released file of episodes has these bytes, None where there is none."""
        files = {split: self.directory / "episodes" / f"{split}.jsonl" for split in self.settings.splits}
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
        files = self._metrics(kind, split)
        if files is None:
            return [], []
        arms = self.settings.arms
        controls = [one for one in self.settings.comparisons.controls if one in arms and arms[one].control]
        named = [*sorted(self.references(kind)), *(one for one in controls if arms[one].kind is kind)]
        place = {arm: number for number, arm in enumerate(named)}
        row: type[StaticOutcome] | type[EmbodiedOutcome] = StaticOutcome if kind is Kind.STATIC else EmbodiedOutcome
        outcomes: Sequence[Outcome] = read_rows(files[1], row, place)
        rates = read_rows(files[0], Rate, place)
        return sorted(rates, key=lambda rate: place[rate.arm]), sorted(outcomes, key=lambda outcome: place[outcome.arm])

    def entered(self, kind: Kind, split: str, among: Collection[str]) -> dict[str, list[Rate]]:
        """Return the rates of the leaderboard's entries that drive on a split, over some of its episodes, by name.

        Empty where the release has metrics of that kind on the split: its arms stand there. among: ids of the episodes.
        """
        if not among or self._metrics(kind, split) is not None:
            return {}
        source = self.episodes(split)
        sha256 = hashlib.sha256(source.read_bytes()).hexdigest()
        cases = [Case.of(episode) for episode in Episode.load(source) if episode.id in among]
        found = {}
        for path in sorted(self.leaderboard.glob(f"*/{split}/{FILE}")):
            with suppress(ValueError, OSError):  # `ovman leaderboard` says what is wrong with an entry
                manifest = read_manifest(path.parent)
                if manifest.sha256 == sha256:
                    runs = [run for _, run in read_runs(runs_path(path.parent)) if run.episode in among]
                    rates = embodied_rates(embodied_outcomes(cases, runs), self.settings.evaluation.confidence)
                    found[self._named(manifest)] = rates
        return dict(sorted(found.items(), key=lambda entry: -entry[1][-1].rate))

    def _named(self, manifest: Manifest) -> str:
        """Return the name of an entry's system, with its role if it has no rank."""
        arm = self.settings.arms.get(manifest.arm)
        name = manifest.arm if arm is None else arm.system
        role = "diagnostic" if manifest.handed else "control" if arm is not None and arm.control else None
        return name if role is None else f"{name} ({role})"

    def _metrics(self, kind: Kind, split: str) -> list[Path] | None:
        """The files of rates and of outcomes of a kind on a split, None where the release has none."""
        name = {MAIN: str(kind)}.get(split, split if kind is Kind.STATIC else f"{split}_{kind}")
        files = [self.directory / "metrics" / f"{name}_{part}.csv" for part in ("rates", "outcomes")]
        return files if all(path.is_file() for path in files) else None
