"""The tables of what arms answered: points on the static gate, and embodied runs, as they are released."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from ovman.dataset.columns import Column, Kind, Table
from ovman.dataset.text import json_text
from ovman.records.prediction import Prediction
from ovman.records.run import Score

PREDICTIONS = Table(
    "predictions",
    "A row is what one arm answers to one episode without driving, in one of its runs: a point, an abstention, or what a "
    "stochastic arm picks its point from. It holds no verdict; `ovman score` gives it.",
    (
        Column("episode", Kind.TEXT, "`episode` of `episodes`"),
        Column("split", Kind.TEXT, "split of the episode"),
        Column("arm", Kind.TEXT, "who answers"),
        Column("seed", Kind.WHOLE, "number of the arm's run"),
        Column("x", Kind.REAL, "of a point, metres"),
        Column("z", Kind.REAL, "of a point, metres"),
        Column("confidence", Kind.REAL, "of a point, how probable the arm holds it"),
        Column("abstain", Kind.TEXT, "why the arm gives no answer"),
        Column("candidates", Kind.JSON, "points of which each is picked as likely, metres"),
        Column("box", Kind.JSON, "box in which each point is picked as likely, metres"),
        Column("evidence", Kind.JSON, "what the answer was drawn from, as indices of the arm's own maps"),
    ),
)
RUNS = Table(
    "runs",
    "A row is one embodied run of an arm on an episode under one seed, measured where it ended, and judged.",
    (
        Column("episode", Kind.TEXT, "`episode` of `episodes`"),
        Column("split", Kind.TEXT, "split of the episode"),
        Column("arm", Kind.TEXT, "who drives"),
        Column("seed", Kind.WHOLE, "seed of the run"),
        Column("outcome", Kind.TEXT, "how it ended: stopped, abstained, budget or stalled"),
        Column("stop_x", Kind.REAL, "where it stopped, metres"),
        Column("stop_z", Kind.REAL, "where it stopped, metres"),
        Column("stop_yaw_deg", Kind.REAL, "which way it looked there, degrees"),
        Column("box_distance_m", Kind.REAL, "from the stop to the box of the instance that is meant, metres"),
        Column("answer_distance_m", Kind.REAL, "from the stop to the answer, metres"),
        Column("navigable_distance_m", Kind.REAL, "from the stop to the reachable position nearest to the answer, metres"),
        Column("visible_px", Kind.JSON, "pixels of the instance that is meant by pitch of the camera in degrees"),
        Column("path_length_m", Kind.REAL, "metres travelled"),
        Column("actions", Kind.WHOLE, "number of actions"),
        Column("instances", Kind.JSON, "distance and pixels of every instance, for an arm judged on a task of its own, too"),
        Column("path_at_m", Kind.JSON, "metres travelled by number of actions"),
        Column("trace", Kind.TEXT, "all actions, a letter each: F forward, L and R turns, S stop, A abstain"),
        Column("success", Kind.FLAG, "Eq. 4"),
        Column("spl", Kind.REAL, "Eq. 5"),
        Column("own_success", Kind.FLAG, "success on the arm's own task"),
    ),
)
Answered = TypeVar("Answered", Prediction, Score)


def answers_in(folder: Path, of: type[Answered], splits: Mapping[str, str]) -> dict[str, list[Answered]]:
    """The records below a folder by split, sorted by arm, run and episode.

    splits: of the episodes that count by their ids, in order; records of others are passed over. RecordError for a torn record.
    """
    place = {episode: number for number, episode in enumerate(splits)}
    every = [record for file in sorted(folder.rglob("*.jsonl")) for record in of.read(file) if record.episode in place]
    every.sort(key=lambda record: (record.arm, record.seed, place[record.episode]))
    found: dict[str, list[Answered]] = {split: [] for split in splits.values()}
    for record in every:
        found[splits[record.episode]].append(record)
    return {split: records for split, records in found.items() if records}


def prediction_rows(predictions: Sequence[Prediction], split: str) -> Iterator[dict[str, Any]]:
    """A row a prediction, in their order. ValueError for a record with a key that has no column."""
    for prediction in predictions:
        yield _row(PREDICTIONS, prediction.to_json(), split)


def run_rows(runs: Sequence[Score], split: str) -> Iterator[dict[str, Any]]:
    """A row a run, in their order. ValueError for a record with a key that has no column."""
    for run in runs:
        record = run.to_json()
        stop = record.pop("stop") or {}
        yield _row(RUNS, record | {f"stop_{name}": at for name, at in stop.items()}, split)


def _row(table: Table, record: dict[str, Any], split: str) -> dict[str, Any]:
    """The row of a record; columns that it does not mention are empty."""
    values = dict.fromkeys(column.name for column in table.columns) | record | {"split": split}
    del values["schema"]
    for column in table.columns:
        if column.kind is Kind.JSON:
            values[column.name] = json_text(values[column.name])
    return table.row(values)
