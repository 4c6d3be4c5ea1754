"""Read the files of a results directory that a page about an episode shows, each once.

The episodes and their scenes are required. Any other file may be missing; the page then says so.
"""

from __future__ import annotations

import csv
import difflib
import fnmatch
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from ovman.perception.clusters import Cluster
from ovman.perception.maps import build_map
from ovman.perception.records import Detected, read_detections, read_maps, read_nouns
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.records.scene import Scene
from ovman.records.visit import Sightings, Visit
from ovman.settings import MAIN, Arm, Kind, of_kind

MAKE = "make tables"
"""The command that makes these files."""
Record = TypeVar("Record", Prediction, Score)
NOTHING: Mapping[str, Detected] = MappingProxyType({})


class ShowError(ValueError):
    """An episode that cannot be shown; one line with the remedy."""


class Results:
    """The results in a directory. Only `episodes` and `scene` fail for a missing file; the others return None or nothing.

    Args:
        directory: The results, or a release.
        arms: Arms of the settings.
        splits: All splits with the names of the arms that answer them; of main there may be none, which means all arms.
        apart: Splits that `make tables` leaves out.
    """

    def __init__(
        self,
        directory: Path,
        arms: Sequence[Arm],
        splits: Mapping[str, Sequence[str]] = MappingProxyType({}),
        apart: Collection[str] = (),
    ) -> None:
        self.directory, self.arms, self.apart = Path(directory), tuple(arms), apart
        self.splits = {MAIN: [arm.name for arm in arms], **splits}
        self._supplied: dict[str, Path] = {}
        self._seen: Mapping[str, Detected] = {}
        self._mapped: Mapping[str, tuple[Cluster, ...]] = {}

    def supply(
        self,
        episode: Episode,
        tours: Mapping[str, Path],
        seen: Mapping[str, Detected] = NOTHING,
        noun: np.ndarray | None = None,
        radius_m: float = 0.0,
    ) -> None:
        """Take files of one episode that the results lack, in place of those of the episode before.

        Args:
            episode: The episode.
            tours: Folders of its recorded tours by "first" and "second".
            seen: Detections by the name of the visit.
            noun: The embedding (K,) of the episode's noun.
            radius_m: Radius of the clusters that make a map of detections.
        """
        self._supplied = {episode.visits[which]: place for which, place in tours.items()}
        self._seen = seen
        self._mapped = {visit: build_map([one], radius_m) for visit, one in seen.items()}
        if noun is not None:
            self.nouns = {**self.nouns, episode.noun: noun}

    def command(self, split: str) -> str:
        """Return the command that makes the predictions, the runs and the verdicts of a split."""
        return f"snakemake --cores 2 -- results/splits/{split}" if split in self.apart else MAKE

    def arms_of(self, split: str, kind: Kind) -> list[Arm]:
        """Return the arms of a kind that answer a split, in the order of the tables: controls last."""
        arms = sorted(of_kind(self.arms, kind), key=lambda arm: arm.control)
        return [arm for arm in arms if arm.name in self.splits[split]]

    @cached_property
    def episodes(self) -> Mapping[str, Episode]:
        """Episodes of all splits by id, in the order of the files.

        Raises:
            ShowError: Those of split main are missing.
        """
        self._require(f"episodes/{MAIN}.jsonl")
        files = [self.directory / "episodes" / f"{split}.jsonl" for split in self.splits]
        return {episode.id: episode for file in files if file.is_file() for episode in Episode.load(file)}

    def choose(self, patterns: Sequence[str]) -> list[str]:
        """Return the ids that match any of the patterns (shell wildcards), in the order of the files.

        Raises:
            ShowError: A pattern matches none; the message has the nearest id.
        """
        wanted: set[str] = set()
        for pattern in patterns:
            found = [name for name in self.episodes if name == pattern] or fnmatch.filter(self.episodes, pattern)
            if not found:
                near = difflib.get_close_matches(pattern, self.episodes, n=1, cutoff=0.0)
                hint = f"; the nearest is {near[0]}" if near else ""
                raise ShowError(f"{self.directory}: no such episode: {pattern}{hint}")
            wanted.update(found)
        return [name for name in self.episodes if name in wanted]

    def scene(self, episode: Episode) -> Scene:
        """Return the scene of an episode.

        Raises:
            ShowError: The file is missing or lacks the scene.
        """
        scenes = self._scenes(episode.split)
        if episode.scene not in scenes:
            raise ShowError(f"{self.directory}/scenes/{episode.split}.jsonl lacks {episode.scene}; make it with `{MAKE}`")
        return scenes[episode.scene]

    def sightings(self, episode: Episode) -> Sightings | None:
        """Return what the tours of an episode truly show."""
        return self._sightings(episode.split).get(episode.id)

    def visit_directory(self, episode: Episode, which: str) -> Path:
        """Return the directory of the recorded tour `which` ("first" or "second") of an episode."""
        visit = episode.visits[which]
        return self._supplied.get(visit, self.directory / "visits" / episode.scene / visit)

    @cache  # noqa: B019 (an object serves one command)
    def visit(self, directory: Path) -> Visit | None:
        """Return the recorded tour in a directory."""
        return Visit.load(directory) if (directory / "visit.json").is_file() else None

    def map(self, episode: Episode, which: str) -> tuple[Cluster, ...] | None:
        """Return the reference agent's map of a visit."""
        visit = episode.visits[which]
        return self._maps(episode.split, episode.scene).get(visit, self._mapped.get(visit))

    def detections(self, episode: Episode, which: str) -> Detected | None:
        """Return the detections of a visit."""
        visit = episode.visits[which]
        return self._detections(episode.split, episode.scene).get(visit, self._seen.get(visit))

    @cached_property
    def nouns(self) -> Mapping[str, np.ndarray]:
        """Embeddings (K,) of noun phrases."""
        path = self.directory / "nouns.npz"
        return read_nouns(path) if path.is_file() else {}

    def predictions(self, episode: Episode) -> Mapping[str, Mapping[int, Prediction]]:
        """Return the predictions of the static arms for an episode, by arm and run; most arms have one run, 0."""
        arms = [arm.name for arm in self.arms_of(episode.split, Kind.STATIC)]
        by_arm = {arm: self._predictions(episode.split, arm).get(episode.id) for arm in arms}
        return {arm: {one.seed: one for one in of_arm} for arm, of_arm in by_arm.items() if of_arm}

    def static_verdict(self, arm: str, run: int, episode: Episode) -> Mapping[str, str] | None:
        """Return the row of an answer in the metrics `static_outcomes`."""
        return self._outcomes(episode.split).get((arm, str(run), episode.id))

    def runs(self, arm: str, episode: Episode) -> Mapping[int, Score]:
        """Return the judged runs of an arm that navigates, by seed."""
        return {run.seed: run for run in self._runs(episode.split, arm).get(episode.id, ())}

    def _require(self, name: str) -> Path:
        path = self.directory / name
        if not path.is_file():
            raise ShowError(f"{path} is missing; make it with `{MAKE}`, or name another directory with --results")
        return path

    @cache  # noqa: B019
    def _scenes(self, split: str) -> Mapping[str, Scene]:
        return {scene.scene: scene for scene in Scene.read(self._require(f"scenes/{split}.jsonl"))}

    @cache  # noqa: B019
    def _sightings(self, split: str) -> Mapping[str, Sightings]:
        path = self.directory / "sightings" / f"{split}.jsonl"
        return {one.episode: one for one in Sightings.read(path)} if path.is_file() else {}

    @cache  # noqa: B019
    def _maps(self, split: str, scene: str) -> Mapping[str, tuple[Cluster, ...]]:
        path = self.directory / "maps" / split / f"{scene}.npz"
        return read_maps(path) if path.is_file() else {}

    @cache  # noqa: B019
    def _detections(self, split: str, scene: str) -> Mapping[str, Detected]:
        path = self.directory / "detections" / split / f"{scene}.npz"
        return read_detections(path) if path.is_file() else {}

    @cache  # noqa: B019
    def _predictions(self, split: str, arm: str) -> Mapping[str, Sequence[Prediction]]:
        path = self.directory / "predictions" / split / f"{arm}.jsonl"
        answers = sorted(Prediction.read(path), key=lambda one: one.seed) if path.is_file() else []
        return _group(answers)

    @cache  # noqa: B019
    def _runs(self, split: str, arm: str) -> Mapping[str, Sequence[Score]]:
        path = self.directory / "scores" / split / f"{arm}.jsonl"
        return _group(Score.read(path)) if path.is_file() else {}

    @cache  # noqa: B019
    def _outcomes(self, split: str) -> Mapping[tuple[str, str, str], Mapping[str, str]]:
        path = self.directory / "metrics" / split / "static_outcomes.csv"
        if not path.is_file():
            return {}
        with path.open(encoding="utf-8", newline="") as file:
            return {(row["arm"], row["seed"], row["episode"]): row for row in csv.DictReader(file)}


def _group(records: Iterable[Record]) -> dict[str, list[Record]]:
    """Return records by the id of their episode."""
    found: dict[str, list[Record]] = {}
    for one in records:
        found.setdefault(one.episode, []).append(one)
    return found
