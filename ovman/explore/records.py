"""The records of a split that the page is made of, from a release or from results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.entry.errors import EntryError
from ovman.records.certification import Certification, OracleRun
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.records.trial import Trial
from ovman.settings import MAIN, Kind, Settings, arms_of, of_kind


@dataclass(frozen=True, slots=True)
class Records:
    """Of one split. certified: the oracle's runs by trial. predictions: by static arm; runs: by embodied arm."""

    split: str
    trials: Sequence[Trial]
    certified: dict[str, Sequence[OracleRun]]
    episodes: Sequence[Episode]
    predictions: dict[str, list[Prediction]]
    runs: dict[str, list[Score]]


def read(directory: Path, settings: Settings, split: str) -> Records:
    """The records below a release or a results folder. EntryError or RecordError, in one line, for what is not there."""
    file = directory / "episodes" / f"{split}.jsonl"
    trials = sorted((directory / "trials").glob("*.jsonl"))
    if not file.is_file() or not trials:
        raise EntryError(f"{file if trials else directory / 'trials'}: is not there; name a release or results with --release")
    below = "" if split == MAIN else f"{split}/"
    predictions = {
        arm.name: Prediction.read(path)
        for arm in of_kind(arms_of(settings.arms), Kind.STATIC)
        if (path := directory / "predictions" / f"{below}{arm.name}.jsonl").is_file()
    }
    runs = {
        arm.name: [run for path in paths for run in Score.read(path)]
        for arm in of_kind(arms_of(settings.arms), Kind.EMBODIED)
        if (paths := _runs(directory, split, arm.name))
    }
    return Records(
        split,
        [trial for path in trials for trial in Trial.read(path) if trial.candidate.split == split],
        {one.id: one.runs for path in sorted((directory / "certified").glob("*.jsonl")) for one in Certification.read(path)},
        Episode.load(file),
        predictions,
        runs,
    )


def _runs(directory: Path, split: str, arm: str) -> list[Path]:
    """The files of judged runs, which results call scores."""
    for name in ("scores", "runs"):
        above = directory / name
        if above.is_dir():
            one = above / split / f"{arm}.jsonl"
            return sorted((above / arm).glob("seed*/*.jsonl")) if split == MAIN else [one] if one.is_file() else []
    return []
