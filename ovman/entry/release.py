"""The released files that an entry is judged by, and the baselines that its score is compared with."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from ovman.analysis.comparisons import Comparison, compare
from ovman.analysis.outcomes import Outcome, embodied_outcomes, group_by, is_expectation
from ovman.analysis.rates import Rate, arm_rates, chances
from ovman.analysis.rows import read_rows
from ovman.entry import LEADERBOARD, EntryError
from ovman.entry.manifest import FILE, Manifest, read_manifest, read_runs, runs_path
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.settings import Kind, Pair, Settings


@dataclass(frozen=True, slots=True)
class Release:
    """A folder of released files, and the settings that name its splits and arms."""

    directory: Path
    settings: Settings
    leaderboard: Path = LEADERBOARD

    def episodes(self, split: str) -> Path:
        """Return the file of a split's episodes. EntryError for a name that is not a split's, and if the release lacks it."""
        if split not in self.settings.splits:
            raise EntryError(f"--split: {split} is no split; write one of {', '.join(self.settings.splits)}")
        path = self._episodes(split)
        if not path.is_file():
            raise EntryError(f"{path}: the release has no episodes of the split {split}; name a release with --release")
        return path

    def split_of(self, episodes: bytes) -> str | None:
        """Return the split whose released file of episodes has these bytes, None if there is none."""
        files = {split: self._episodes(split) for split in self.settings.splits}
        return next((split for split, file in files.items() if file.is_file() and file.read_bytes() == episodes), None)

    def scores(self, arm: str, split: str) -> list[Score]:
        """Return the scored runs of an arm on a split, empty if the release has none."""
        path = self.directory / "scores" / split / f"{arm}.jsonl"
        return Score.read(path) if path.is_file() else []

    def references(self, kind: Kind) -> frozenset[str]:
        """Return the reference agent: `comparisons.agent`, or the embodied arms that execute its answers."""
        agent = self.settings.comparisons.agent
        executing = {name for name, arm in self.settings.arms.items() if arm.kind is kind and arm.executes == agent}
        return frozenset({agent} if kind is Kind.STATIC else executing)

    def baselines(self, kind: Kind, split: str) -> tuple[list[Rate], Sequence[Outcome]]:
        """Return rates and outcomes, on a split, of the arms of a kind that are the reference agent or controls.

        The reference agent comes first. Empty if the release has no metrics of that kind on the split.
        """
        files = self._metrics(kind, split)
        if files is None:
            return [], []
        arms = self.settings.arms
        controls = [one for one in self.settings.comparisons.controls if one in arms and arms[one].control]
        named = [*sorted(self.references(kind)), *(one for one in controls if arms[one].kind is kind)]
        place = {arm: number for number, arm in enumerate(named)}
        outcomes = read_rows(files[1], Outcome, place)
        rates = read_rows(files[0], Rate, place)
        return sorted(rates, key=lambda rate: place[rate.arm]), sorted(outcomes, key=lambda outcome: place[outcome.arm])

    def entered(self, kind: Kind, split: str, among: Collection[str]) -> dict[str, list[Rate]]:
        """Return the rates of the leaderboard's entries that navigate on a split, over some of its episodes, by name.

        Empty if the release has metrics of that kind on the split. among: Ids of the episodes.
        """
        if not among or self._metrics(kind, split) is not None:
            return {}
        source = self.episodes(split)
        sha256 = hashlib.sha256(source.read_bytes()).hexdigest()
        episodes = [episode for episode in Episode.load(source) if episode.id in among]
        rates = {}
        for path in sorted(self.leaderboard.glob(f"*/{split}/{FILE}")):
            with suppress(ValueError, OSError):  # `ovman leaderboard` says what is wrong with an entry
                manifest = read_manifest(path.parent)
                if manifest.sha256 == sha256:
                    runs = [run for _, run in read_runs(runs_path(path.parent)) if run.episode in among]
                    outcomes = embodied_outcomes(episodes, runs)
                    rates[self._system(manifest)] = arm_rates(outcomes, self.settings.evaluation.confidence)
        return dict(sorted(rates.items(), key=lambda entry: -entry[1][-1].rate))

    def _system(self, manifest: Manifest) -> str:
        """Return the name of an entry's system, with its role if it has no rank."""
        arm = self.settings.arms.get(manifest.arm)
        name = manifest.arm if arm is None else arm.system
        role = "diagnostic" if manifest.handed else "control" if arm is not None and arm.control else None
        return name if role is None else f"{name} ({role})"

    def _episodes(self, split: str) -> Path:
        return self.directory / "episodes" / f"{split}.jsonl"

    def _metrics(self, kind: Kind, split: str) -> list[Path] | None:
        """Return the files of rates and of outcomes of a kind on a split, None if the release lacks them."""
        files = [self.directory / "metrics" / split / f"{kind}_{part}.csv" for part in ("rates", "outcomes")]
        return files if all(path.is_file() for path in files) else None


@dataclass(frozen=True, slots=True)
class Baselines:
    """Released arms, chance and exact tests next to a score, which show it if a control reaches the score.

    Attributes:
        references: The arms that are the reference agent.
        released: Rates by relation, then all, of these and of the controls.
        chance: Mean of 1/n_i by relation and over all; n_i is the number of instances of an episode's category.
        tests: Each run that was judged against the released arms, by relation, then all.
        untested: One line for each arm that is not tested, with the reason.
        systems: Titles of the released arms, by name.
        entries: Rates on the same episodes, by name, of the leaderboard's entries on a split without released rates.
    """

    references: frozenset[str]
    released: Sequence[Rate]
    chance: Mapping[str, float]
    tests: Sequence[Comparison]
    untested: Sequence[str]
    systems: Mapping[str, str]
    entries: Mapping[str, Sequence[Rate]] = field(default_factory=dict)

    def reaching(self, rate: float) -> list[tuple[str, float]]:
        """Return the controls, and chance, whose success over all is not below `rate`, each with its success."""
        controls = [
            (self.systems[arm], of[-1].rate) for arm, of in group_by(self.released, "arm").items() if arm not in self.references
        ]
        candidates = [*controls, ("chance 1/n", self.chance["all"])]
        return [(name, own) for name, own in candidates if round(own, DECIMALS) >= round(rate, DECIMALS)]


DECIMALS = 6
"""Of released rates: a control that ties must not seem to fall short by what the file has rounded away."""


def compare_with_baselines(
    outcomes: Sequence[Outcome], kind: Kind, split: str | None, release: Release, is_whole: bool = True
) -> Baselines:
    """Return the baselines of outcomes of arms of one kind.

    A static run is tested against the arms that were realised once, an embodied one against runs under its own seed. Released
    arms and tests are given only if the outcomes cover the split (`is_whole`). split: None for episodes of no released split.
    """
    rates, released = ([], []) if split is None or not is_whole else release.baselines(kind, split)
    entries = {} if split is None else release.entered(kind, split, {outcome.episode for outcome in outcomes})
    systems = {name: arm.system for name, arm in release.settings.arms.items()}
    tests, untested = _test(outcomes, released, kind, systems)
    chance = chances(outcomes)
    by_relation = {relation: of_n for relation, (of_n, _) in chance.items()}
    return Baselines(release.references(kind), rates, by_relation, tests, untested, systems, entries)


def _test(
    judged: Sequence[Outcome], released: Sequence[Outcome], kind: Kind, systems: Mapping[str, str]
) -> tuple[list[Comparison], list[str]]:
    tests, untested = [], []
    baselines = {}
    for name, outcomes in group_by(released, "arm").items():
        runs = group_by(outcomes, "seed")
        if any(map(is_expectation, outcomes)):
            untested.append(f"{systems[name]}: a stochastic pick")
        elif kind is Kind.STATIC and len(runs) > 1:
            untested.append(f"{systems[name]}: {len(runs)} runs")
        else:
            baselines[name] = runs
    for arm, outcomes in group_by(judged, "arm").items():
        if any(map(is_expectation, outcomes)):
            untested.append(f"{arm}, which is judged: a stochastic pick")
            continue
        for seed, run in group_by(outcomes, "seed").items():
            for name, runs in baselines.items():
                baseline = runs.get(seed) if kind is Kind.EMBODIED else next(iter(runs.values()))
                if baseline is None:
                    untested.append(f"{systems[name]}: no run under seed {seed}")
                else:
                    tests += compare(Pair(name=f"{arm} against {name}", arm=arm, baseline=name), seed, run, baseline)
    return tests, untested
