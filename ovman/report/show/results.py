"""The files of a results directory that a page about an episode is made from, each read once.

The episodes and their scenes must be there. Everything else may be missing, and a page says so in its place.
"""

from __future__ import annotations

import csv
import difflib
import fnmatch
import json
from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from ovman.analysis.metrics import EMBODIED_OUTCOMES, STATIC_OUTCOMES
from ovman.evaluation import prediction
from ovman.evaluation.prediction import Prediction
from ovman.models.record import read_records, records
from ovman.models.settings import Arm, Kind, of_kind
from ovman.models.visit import Visit
from ovman.perception.clusters import Cluster

MAKE = "make tables"
"""The command that makes all that is read here."""


class ShowError(ValueError):
    """What was asked for cannot be shown; one line with the remedy."""


class Results:
    """Reads `directory`. Every reader but `episodes` and `scene` returns None, or nothing, for what is not there.

    arms: those of the settings.
    """

    def __init__(self, directory: Path, arms: Sequence[Arm]) -> None:
        self.directory, self.arms = Path(directory), tuple(arms)

    @cached_property
    def episodes(self) -> Mapping[str, Mapping[str, Any]]:
        """Episode records by id, in the order of the file. ShowError where there is no file."""
        return {episode["id"]: episode for episode in read_records(self._needed("episodes/main.jsonl"))}

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
    def scene(self, name: str) -> Mapping[str, Any]:
        """The record of a scene. ShowError where there is none."""
        return json.loads(self._needed(f"scenes/{name}.json").read_text(encoding="utf-8"))

    def trial(self, episode: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """What was measured for an episode."""
        return self._trials(episode["scene"]).get(episode["id"])

    def visit_directory(self, episode: Mapping[str, Any], which: str) -> Path:
        """Where the recorded tour `which` ("first" or "second") of an episode is."""
        return self.directory / "visits" / episode["scene"] / episode["visits"][which]

    @cache  # noqa: B019
    def visit(self, directory: Path) -> Visit | None:
        """The recorded tour in a directory."""
        return Visit.load(directory) if (directory / "visit.json").is_file() else None

    def map(self, episode: Mapping[str, Any], which: str) -> tuple[Cluster, ...] | None:
        """The agent's map of a visit."""
        return self._maps(episode["scene"]).get(episode["visits"][which])

    def detected(self, episode: Mapping[str, Any], which: str) -> Any:
        """What the detector found in a visit: an `ovman.perception.records.Detected`."""
        return self._detections(episode["scene"]).get(episode["visits"][which])

    @cached_property
    def nouns(self) -> Mapping[str, Any]:
        """The embeddings (K,) of noun phrases."""
        path = self.directory / "nouns.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_nouns

        return read_nouns(path)

    def predictions(self, episode: str) -> Mapping[str, Mapping[int, Prediction]]:
        """What the static arms answered to an episode, by arm and run; most arms have one run, 0."""
        return {arm: answered[episode] for arm, answered in self._predictions.items() if episode in answered}

    def static_verdict(self, arm: str, run: int, episode: str) -> Mapping[str, str] | None:
        """The row of `static_outcomes.csv`."""
        return self._verdicts(STATIC_OUTCOMES).get((arm, str(run), episode))

    def embodied_verdicts(self, arm: str, episode: str) -> Mapping[int, Mapping[str, str]]:
        """The rows of `embodied_outcomes.csv` by seed."""
        rows = self._verdicts(EMBODIED_OUTCOMES)
        return {int(seed): row for (name, seed, id), row in rows.items() if (name, id) == (arm, episode)}

    def runs(self, arm: str, episode: Mapping[str, Any]) -> Mapping[int, Mapping[str, Any]]:
        """The judged runs of an embodied arm by seed."""
        found = {}
        for seed in sorted((self.directory / "runs" / arm).glob("seed*")):
            run = self._runs(seed / f"{episode['scene']}.jsonl").get(episode["id"])
            if run is not None:
                found[int(run["seed"])] = run
        return found

    def _needed(self, name: str) -> Path:
        path = self.directory / name
        if not path.is_file():
            raise ShowError(f"{path} is not there; make it with `{MAKE}`, or name another directory with --results")
        return path

    @cache  # noqa: B019
    def _trials(self, scene: str) -> Mapping[str, Mapping[str, Any]]:
        path = self.directory / "trials" / f"{scene}.jsonl"
        return {trial["candidate"]["id"]: trial for _, trial in records(path)} if path.is_file() else {}

    @cache  # noqa: B019
    def _maps(self, scene: str) -> Mapping[str, tuple[Cluster, ...]]:
        path = self.directory / "maps" / f"{scene}.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_maps

        return read_maps(path)

    @cache  # noqa: B019
    def _detections(self, scene: str) -> Mapping[str, Any]:
        path = self.directory / "detections" / f"{scene}.npz"
        if not path.is_file():
            return {}
        from ovman.perception.records import read_detections

        return read_detections(path)

    @cached_property
    def _predictions(self) -> Mapping[str, Mapping[str, Mapping[int, Prediction]]]:
        found: dict[str, dict[str, dict[int, Prediction]]] = {}
        for arm in of_kind(self.arms, Kind.STATIC):
            path = self.directory / "predictions" / f"{arm.name}.jsonl"
            if path.is_file():
                answered = found.setdefault(arm.name, {})
                for one in sorted(prediction.read(path), key=lambda one: one.seed):
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
    def _runs(self, path: Path) -> Mapping[str, Mapping[str, Any]]:
        return {run["episode"]: run for _, run in records(path)} if path.is_file() else {}
