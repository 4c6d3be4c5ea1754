"""Read the files of a results directory, of the release, or of a draw, that a page about an episode shows."""

from __future__ import annotations

import difflib
import fnmatch
from collections.abc import Iterator, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any, cast

from ovman.analysis.outcomes import Outcome
from ovman.analysis.rows import read_rows
from ovman.draws.folder import holds_draw, read_draw
from ovman.records.draw import EPISODES, SCENES, Draw
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.record import Record
from ovman.records.run import Score
from ovman.records.scene import Scene
from ovman.settings import Arm, Kind, Settings


class ShowError(ValueError):
    """An episode that cannot be shown; one line with the remedy."""


class Results:
    """The results in a directory. Episodes and scenes are required; what else is missing is left out."""

    def __init__(self, directory: Path, settings: Settings) -> None:
        self.directory, self.settings = directory, settings

    @cached_property
    def episodes(self) -> dict[str, Episode]:
        """Episodes of all splits by id, those of the settings first. Raises ShowError if there are none."""
        return {one.id: one for split in self.splits for one in self.of_split(split)}

    @property
    def splits(self) -> list[str]:
        """The splits that have episodes, those of the settings first. Raises ShowError if there are none."""
        known = [split for split in self.settings.splits if split in self._files]
        if not self._files:
            remedy = "make them with `make tables`, or name another directory with --results"
            raise ShowError(f"{self.directory / 'episodes'}: no episodes; {remedy}")
        return list(dict.fromkeys([*known, *self._files]))

    def of_split(self, split: str) -> list[Episode]:
        """Return the episodes of a split. Raises ShowError if it has none."""
        if split not in self.splits:
            raise ShowError(f"{self.directory}: no episodes of split {split}; there are those of {', '.join(self.splits)}")
        return Episode.load(self._files[split])

    @cached_property
    def _files(self) -> dict[str, Path]:
        """Files of episodes by split."""
        files = {file.stem: file for file in sorted((self.directory / "episodes").glob("*.jsonl"))}
        return files if self._draw is None else files | {self._draw.split: self.directory / EPISODES}

    @cached_property
    def _draw(self) -> Draw | None:
        """The draw that the directory is, None for others. DrawError for one that was changed."""
        return read_draw(self.directory) if holds_draw(self.directory) else None

    def choose(self, patterns: Sequence[str]) -> list[Episode]:
        """Return the episodes that match any of the shell wildcards. Raises ShowError for one without a match."""
        wanted: set[str] = set()
        for pattern in patterns:
            found = [name for name in self.episodes if name == pattern] or fnmatch.filter(self.episodes, pattern)
            if not found:
                (near,) = difflib.get_close_matches(pattern, self.episodes, n=1, cutoff=0.0)
                raise ShowError(f"{self.directory}: no such episode: {pattern}; the nearest is {near}")
            wanted.update(found)
        return [episode for name, episode in self.episodes.items() if name in wanted]

    def scene(self, episode: Episode) -> Scene:
        """Return the scene of an episode. Raises ShowError if it is missing."""
        file = self.directory / (Path("scenes", f"{episode.split}.jsonl") if self._draw is None else SCENES)
        for scene in self._read(Scene, file):
            if scene.scene == episode.scene:
                return cast(Scene, scene)
        raise ShowError(f"{file}: lacks {episode.scene}; make it with `make tables`")

    def arms(self, episode: Episode, kind: Kind) -> list[Arm]:
        """Return the arms of a kind that answer the episode's split, in the order of the tables: controls last.

        Every arm may answer a split that the settings do not have.
        """
        splits = self.settings.splits
        named = splits[episode.split].arms if episode.split in splits else self.settings.arms
        arms = [arm for name, arm in self.settings.arms.items() if arm.kind is kind and name in named]
        return sorted(arms, key=lambda arm: arm.control)

    def predictions(self, arm: str, episode: Episode) -> Iterator[tuple[Prediction, Outcome | None]]:
        """Yield the predictions of a static arm with their rows of the metrics, one per run."""
        verdicts = self._verdicts(episode.split)
        file = self.directory / "predictions" / episode.split / f"{arm}.jsonl"
        for prediction in self._of_episode(Prediction, file, episode.id):
            yield prediction, verdicts.get((arm, prediction.seed, episode.id))

    def runs(self, arm: str, episode: Episode) -> list[Score]:
        """Return the judged runs of an arm that navigates, one per seed."""
        return self._of_episode(Score, self.directory / "scores" / episode.split / f"{arm}.jsonl", episode.id)

    def _of_episode(self, kind: type[Record], file: Path, episode: str) -> list[Any]:
        found: list[Any] = [one for one in self._read(kind, file) if one.episode == episode]
        return sorted(found, key=lambda one: one.seed)

    @cache  # noqa: B019 (an object serves one command)
    def _read(self, kind: type[Record], file: Path) -> list[Any]:
        return kind.read(file) if file.is_file() else []

    def outcomes(self, split: str, kind: Kind) -> list[Outcome]:
        """Return the judged predictions, or the judged runs, of a split; none without its metrics."""
        file = self.directory / "metrics" / split / f"{kind}_outcomes.csv"
        return read_rows(file, Outcome) if file.is_file() else []

    @cache  # noqa: B019
    def _verdicts(self, split: str) -> dict[tuple[str, int, str], Outcome]:
        return {(row.arm, row.seed, row.episode): row for row in self.outcomes(split, Kind.STATIC)}
