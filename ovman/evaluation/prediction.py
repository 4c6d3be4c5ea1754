"""The record of a prediction: where an arm says that the answer is. It holds no verdict; the evaluator judges it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ovman.agents.reference.decision import Abstention, AbstentionReason, Answer
from ovman.agents.reference.reasoning import Evidence
from ovman.agents.reference.single_visit import UniformBox, UniformPick
from ovman.models.record import line, records

SCHEMA = "ovman-prediction/1"

Outcome = Answer | Abstention | UniformPick | UniformBox


@dataclass(frozen=True, slots=True)
class Prediction:
    """What one arm answered to one episode: a point, an abstention, or what a stochastic arm picks its point from.

    evidence: what it was drawn from, where the arm has a map of its own. No verdict depends on it.
    """

    episode: str
    arm: str
    seed: int
    outcome: Outcome
    evidence: Evidence | None = None

    def to_json(self) -> dict[str, Any]:
        """{"schema", "episode", "arm", "seed"} and one of {"x", "z"}, {"abstain"}, {"candidates": [{"x", "z"}]}, {"box": {...}};
        then, of an arm with a map of its own, {"evidence": {...}}.

        Coordinates are metres on the floor plane, as they were given.
        """
        record: dict[str, Any] = {"schema": SCHEMA, "episode": self.episode, "arm": self.arm, "seed": self.seed}
        record |= outcome_json(self.outcome)
        return record if self.evidence is None else {**record, "evidence": self.evidence.to_json()}

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> Prediction:
        """The inverse of ``to_json``. Raises ValueError that names the key and the remedy."""
        if record.get("schema") != SCHEMA:
            raise ValueError(f'"schema" is {record.get("schema")!r}; this version reads {SCHEMA!r}')
        forms = [key for key in ("x", "abstain", "candidates", "box") if key in record]
        if len(forms) != 1:
            raise ValueError('give exactly one of "x" and "z", "abstain", "candidates", "box"')
        try:
            evidence = Evidence.from_json(record["evidence"]) if "evidence" in record else None
            return cls(str(record["episode"]), str(record["arm"]), int(record["seed"]), _outcome(record, forms[0]), evidence)
        except KeyError as missing:
            raise ValueError(f"{missing} is missing; add it") from None


def read(path: Path) -> list[Prediction]:
    """The predictions of a file of JSON lines. Raises ValueError in one line: file, line number, key and remedy."""
    predictions = []
    for place, record in records(path):
        try:
            predictions.append(Prediction.from_json(record))
        except (ValueError, TypeError) as error:
            raise ValueError(f"{place}: {error}") from None
    return predictions


def write(path: Path, predictions: Iterable[Prediction]) -> None:
    """One JSON line a prediction, in the order given, coordinates rounded as all records are."""
    path.write_text("".join(line(prediction.to_json()) for prediction in predictions), encoding="utf-8")


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    """One of {"x", "z"}, {"abstain"}, {"candidates": [{"x", "z"}]}, {"box": {...}}; metres, as they were given."""
    match outcome:
        case Answer(x, z):
            return {"x": x, "z": z}
        case Abstention(reason):
            return {"abstain": str(reason)}
        case UniformPick(candidates):
            return {"candidates": [{"x": x, "z": z} for x, z in candidates]}
        case UniformBox():
            return {"box": asdict(outcome)}
    raise TypeError(f"not an outcome of a prediction: {outcome!r}")


def _outcome(record: Mapping[str, Any], form: str) -> Outcome:
    match form:
        case "x":
            return Answer(float(record["x"]), float(record["z"]))
        case "abstain":
            reasons = ", ".join(AbstentionReason)
            if record["abstain"] not in list(AbstentionReason):
                raise ValueError(f'"abstain" is {record["abstain"]!r}; the reasons are {reasons}')
            return Abstention(AbstentionReason(record["abstain"]))
        case "candidates":
            return UniformPick(tuple((float(point["x"]), float(point["z"])) for point in record["candidates"]))
        case _:
            box = record["box"]
            return UniformBox(*(float(box[key]) for key in ("x_min", "z_min", "x_max", "z_max")))
