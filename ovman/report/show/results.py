"""The files of a results directory that a page about an episode is made from, each read once.

The episodes and their scenes are required. Everything else may be missing; the page then says so.
"""

from __future__ import annotations

import csv
import difflib
import fnmatch
from collections.abc import Collection, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected
from ovman.perception.maps import build_map
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.records.scene import Scene
from ovman.records.visit import Sightings, Visit
from ovman.settings import MAIN, Arm, Kind, of_kind

MAKE = "make tables"
"""The command that makes these files."""


class ShowError(ValueError):
    """An episode that cannot be shown; one line with the remedy."""


class Results:
    """The results in `directory`. Every reader but `episodes` and `scene` returns None or nothing for a missing file.

    arms: of the settings. splits: all but main, each with the names of the arms that answer it. apart: those
    that `make tables` leaves out.
    """

    def __init__(
        self,
        directory: Path,
        arms: Sequence[Arm],
        splits: Mapping[str, Sequence[str]] = MappingProxyType({}),
        apart: Collection[str] = (),
    ) -> None:
        self.directory, self.arms, self.splits, self.apart = Path(directory), tuple(arms), splits, apart
        self._supplied: dict[str, Path] = {}
        self._seen: Mapping[str, Detected] = {}
        self._mapped: Mapping[str, tuple[Cluster, ...]] = {}

    def supply(
        self,
        episode: Episode,
        tours: Mapping[str, Path],
        seen: Mapping[str, Detected] = MappingProxyType({}),
        noun: np.ndarray | None = None,
        radius_m: float = 0.0,
    ) -> None:
        """Take what the results lack of one episode; it replaces that of the episode before.

        Args:
            episode: The episode.
            tours: Folders of its recorded tours by "first" and "second".
            seen: Detections by the name of the visit.
            noun: The embedding (K,) of the episode's noun.
            radius_m: Of the clusters that make a map of detections.
        """
        self._supplied = {episode.visits[which]: place for which, place in tours.items()}
        self._seen = seen
        self._mapped = {visit: build_map([one], radius_m) for visit, one in seen.items()}
        if noun is not None:
            self.nouns = {**self.nouns, episode.noun: noun}

    def command(self, split: str) -> str:
        """Return the command that makes the predictions, the runs and the verdicts of a split."""
        return f"snakemake --cores 2 -- results/splits/{split}" if split in self.apart else MAKE

    def asked(self, split: str, kind: Kind) -> tuple[Arm, ...]:
        """The arms of a kind that answer a split, in the order of the tables: controls last. All answer the benchmark's own."""
        arms = sorted(of_kind(self.arms, kind), key=lambda arm: arm.control)
        return tuple(arm for arm in arms if split == MAIN or arm.name in self.splits[split])

    @cached_property
    def episodes(self) -> Mapping[str, Episode]:
        """The episodes of all splits by id, in the order of the files. ShowError where those of the main split are missing."""
        self._needed(f"episodes/{MAIN}.jsonl")
        files = self._of_splits("episodes/{}.jsonl")
        return {episode.id: episode for file in files for episode in Episode.load(file)}

    def chosen(self, patterns: Sequence[str]) -> list[str]:
        """The ids that match any of the patterns (shell wildcards), in the order of the file.

        ShowError, with the nearest id, for a pattern that matches none.
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

    @cache  # noqa: B019 (an object serves one command)
    def scene(self, name: str) -> Scene:
        """Return the record of a scene. ShowError if no split has it."""
        self._needed(f"scenes/{MAIN}.jsonl")
        files = self._of_splits("scenes/{}.jsonl")
        found = next((scene for file in files for scene in Scene.read(file) if scene.scene == name), None)
        if found is None:
            raise ShowError(f"{self.directory / 'scenes'}: no record of {name}; make it with `{MAKE}`")
        return found

    def sightings(self, episode: Episode) -> Sightings | None:
        """What diagnostic arms are handed of an episode."""
        return self._sightings.get(episode.id)

    def visit_directory(self, episode: Episode, which: str) -> Path:
        """The directory of the recorded tour `which` ("first" or "second") of an episode."""
        visit = episode.visits[which]
        return self._supplied.get(visit, self.directory / "visits" / episode.scene / visit)

    @cache  # noqa: B019
    def visit(self, directory: Path) -> Visit | None:
        """The recorded tour in a directory."""
        return Visit.load(directory) if (directory / "visit.json").is_file() else None

    def map(self, episode: Episode, which: str) -> tuple[Cluster, ...] | None:
        """The reference agent's map of a visit."""
        visit = episode.visits[which]
        return self._maps(episode.split, episode.scene).get(visit, self._mapped.get(visit))

    def detected(self, episode: Episode, which: str) -> Detected | None:
        """The detections of a visit."""
        visit = episode.visits[which]
        return self._detections(episode.split, episode.scene).get(visit, self._seen.get(visit))

    @cached_property
    def nouns(self) -> Mapping[str, np.ndarray]:
        """The embeddings (K,) of noun phrases."""
        path = self.directory / "nouns.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_nouns

        return read_nouns(path)

    def predictions(self, episode: str) -> Mapping[str, Mapping[int, Prediction]]:
        """The predictions of the static arms for an episode, by arm and run; most arms have one run, 0."""
        return {arm: answered[episode] for arm, answered in self._predictions.items() if episode in answered}

    def static_verdict(self, arm: str, run: int, episode: str) -> Mapping[str, str] | None:
        """The row of `static_outcomes.csv`, or of the outcomes of the episode's split."""
        split = self.episodes[episode].split
        return self._verdicts(f"{split}/static_outcomes.csv").get((arm, str(run), episode))

    def runs(self, arm: str, episode: Episode) -> Mapping[int, Score]:
        """Return the scored runs of an embodied arm by seed."""
        file = self.directory / "scores" / episode.split / f"{arm}.jsonl"
        return {run.seed: run for run in self._runs(file).get(episode.id, ())}

    def _needed(self, name: str) -> Path:
        path = self.directory / name
        if not path.is_file():
            raise ShowError(f"{path} is missing; make it with `{MAKE}`, or name another directory with --results")
        return path

    def _of_splits(self, name: str) -> list[Path]:
        """Return the files of all splits that exist. name: with {} for the split."""
        paths = [self.directory / name.format(split) for split in dict.fromkeys((MAIN, *self.splits))]
        return [path for path in paths if path.is_file()]

    @cached_property
    def _sightings(self) -> Mapping[str, Sightings]:
        return {one.episode: one for path in self._of_splits("sightings/{}.jsonl") for one in Sightings.read(path)}

    @cache  # noqa: B019
    def _maps(self, split: str, scene: str) -> Mapping[str, tuple[Cluster, ...]]:
        path = self.directory / "maps" / split / f"{scene}.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_maps

        return read_maps(path)

    @cache  # noqa: B019
    def _detections(self, split: str, scene: str) -> Mapping[str, Detected]:
        path = self.directory / "detections" / split / f"{scene}.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_detections

        return read_detections(path)

    @cached_property
    def _predictions(self) -> Mapping[str, Mapping[str, Mapping[int, Prediction]]]:
        found: dict[str, dict[str, dict[int, Prediction]]] = {}
        for arm in of_kind(self.arms, Kind.STATIC):
            for path in self._of_splits(f"predictions/{{}}/{arm.name}.jsonl"):
                answered = found.setdefault(arm.name, {})
                for one in sorted(Prediction.read(path), key=lambda one: one.seed):
                    answered.setdefault(one.episode, {})[one.seed] = one
        return found

    @cache  # noqa: B019
    def _verdicts(self, name: str) -> Mapping[tuple[str, str, str], Mapping[str, str]]:
        path = self.directory / "metrics" / name
        if not path.is_file():
            return {}
        arms = {arm.name for arm in self.arms}
        with path.open(encoding="utf-8", newline="") as file:
            return {(row["arm"], row["seed"], row["episode"]): row for row in csv.DictReader(file) if row["arm"] in arms}

    @cache  # noqa: B019
    def _runs(self, path: Path) -> Mapping[str, Sequence[Score]]:
        found: dict[str, list[Score]] = {}
        for run in Score.read(path) if path.is_file() else ():
            found.setdefault(run.episode, []).append(run)
        return found
