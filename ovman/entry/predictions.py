"""A file of predictions as somebody else wrote it, with the line of each. Whatever is wrong is one line."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.entry.errors import EntryError
from ovman.records.prediction import Prediction
from ovman.records.record import records

FORMS = ("x", "z", "abstain", "candidates", "box")
"""Keys of which a record has one, or "x" and "z"."""
EXPECTED = '"x" and "z" in metres, or "abstain" with a reason'

Run = tuple[str, int]
"""An arm and its seed."""


@dataclass(frozen=True, slots=True)
class Submitted:
    """The predictions of a file in its order. missing: of each run that lacks some, the episodes that it does not answer."""

    predictions: Sequence[Prediction]
    missing: Mapping[Run, Sequence[str]]


def read_submitted(path: Path, episodes: Sequence[str], of: str) -> Submitted:
    """The predictions of a JSONL file, each for one of `episodes`.

    A line needs `episode`, and `x` and `z` or another form of `Prediction`; `schema`, `arm` (the name of the file) and `seed` (0)
    may be left out. of: what the episodes are, for messages. Raises EntryError or RecordError, in one line with file, line, key
    and remedy, for a record that is wrong, an episode that is none of these, and one that a run answers twice.
    """
    known, answered = frozenset(episodes), dict[Run, dict[str, str]]()
    predictions = []
    try:
        for place, value in records(path):
            prediction = Prediction.from_json(_whole(value, path.stem, place), place)
            if prediction.episode not in known:
                raise EntryError(
                    f"{place}: episode: {prediction.episode!r} is none of {of}; {_remedy(prediction.episode, episodes)}"
                )
            run = answered.setdefault((prediction.arm, prediction.seed), {})
            if (first := run.setdefault(prediction.episode, place)) != place:
                line = first.rpartition(":")[2]
                says = f"{prediction.episode} is answered in line {line} already, under the same arm and seed"
                raise EntryError(f"{place}: episode: {says}; remove one of the two, or give each run a `seed`")
            predictions.append(prediction)
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}; name a file of JSON lines") from None
    if not predictions:
        raise EntryError(
            f'{path}: holds no prediction; write a line an episode, {{"episode": "{episodes[0]}", "x": 0.5, "z": 1.5}}'
        )
    missing = {run: [one for one in episodes if one not in there] for run, there in answered.items()}
    return Submitted(predictions, {run: absent for run, absent in missing.items() if absent})


def _whole(value: Any, arm: str, place: str) -> Any:
    """The record with what may be left out. EntryError where it holds no answer."""
    if not isinstance(value, dict):
        return value
    if "episode" in value and not any(value.get(form) is not None for form in FORMS):
        others = [key for key in value if key not in Prediction.model_fields and key not in ("schema", "evidence")]
        near = [key for key in others for form in FORMS if difflib.get_close_matches(key.lower(), [form, f"{form}_m"], 1, 0.6)]
        key, remedy = (f"{near[0]}: ", f"rename {near[0]!r}") if near else ("", "add them")
        raise EntryError(f"{place}: {key}the record holds no answer; expected {EXPECTED}; {remedy}")
    return {"schema": "ovman-prediction/1", "arm": arm, "seed": 0} | value


def _remedy(episode: str, episodes: Sequence[str]) -> str:
    """What to write instead of an id. The number of an episode of a further split begins with the split's name."""
    split = episode.rpartition("/")[2].rpartition("-")[0]
    if split and not any(one.rpartition("/")[2].startswith(f"{split}-") for one in episodes):
        return f"name its split, --split {split}"
    near = difflib.get_close_matches(episode, episodes, n=1)
    return f"write {near[0]!r}, or name another split with --split" if near else "name its split with --split"
