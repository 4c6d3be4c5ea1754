"""The record of a prediction, "ovman-prediction/1": where an arm says that the answer is. It holds no verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, Literal, Self

from pydantic import AliasPath, Field, PlainSerializer, model_validator

from ovman.records.geometry import Point
from ovman.records.record import Record, Text, optional, rounded


class AbstentionReason(StrEnum):
    """Why an agent gives no answer; the value is what a prediction record holds."""

    NO_CANDIDATE = "no_candidate"  # the set that the rule looks in is empty, and so is its fallback
    NO_COUNTERPART = "no_counterpart"  # several candidates, and nothing in the other visit to tell them apart by
    DISPLACEMENT_BELOW_TAU = "displacement_below_tau"  # MOVED, FORMER: all matched, and no pair moved far enough
    DISPLACEMENT_ABOVE_TAU = "displacement_above_tau"  # STABLE: even the steadiest pair moved
    NO_MOTION = "no_motion"  # MOVING: no track spreads beyond the threshold
    NOTHING_GROUNDED = "nothing_grounded"  # no object of the maps is what the noun means; so it is with empty maps
    NOT_PARSED = "not_parsed"  # the sentence names no query
    UNSURE = "unsure"  # the best answer is less probable than the agent wants it to be


@dataclass(frozen=True, slots=True)
class Answer:
    """A floor-plane point in metres, world frame. confidence: how probable the agent holds it, None where it does not say."""

    x: float
    z: float
    confidence: float | None = None


@dataclass(frozen=True, slots=True)
class Abstention:
    """No answer, and why."""

    reason: AbstentionReason


def as_recorded(outcome: Answer | Abstention) -> Answer | Abstention:
    """Return an outcome rounded as its record keeps it, 0.1 mm: an agent that navigates there uses the recorded answer."""
    if isinstance(outcome, Abstention):
        return outcome
    return Answer(rounded(outcome.x), rounded(outcome.z), rounded(outcome.confidence))


@dataclass(frozen=True, slots=True)
class UniformPick:
    """One of equally likely candidates: floor-plane points (x, z) in metres. Without candidates there is no answer."""

    candidates: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class UniformBox:
    """A uniform position in an axis-aligned floor-plane rectangle from (x_min, z_min) to (x_max, z_max), metres.

    Raises ValueError where a minimum exceeds its maximum.
    """

    x_min: float
    z_min: float
    x_max: float
    z_max: float

    def __post_init__(self) -> None:
        if not (self.x_min <= self.x_max and self.z_min <= self.z_max):
            raise ValueError(f"a box runs from its smallest to its largest corner, not {self}")


Predicted = Answer | Abstention | UniformPick | UniformBox
"""What an arm predicts: a point, an abstention, or what a stochastic arm picks its point from."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence of an answer. Indices are those of the visits' maps.

    grounded_1, grounded_2: what the noun means in each visit, grounded_1 None where the first visit is not read; pairs: objects
    of the first and of the second visit that were taken for the same. In files {"grounded": {"first": [i] or null,
    "second": [j]}, "pairs": [[i, j]]}.
    """

    grounded_1: Annotated[tuple[int, ...] | None, Field(validation_alias=AliasPath("grounded", "first"))]
    grounded_2: Annotated[tuple[int, ...], Field(validation_alias=AliasPath("grounded", "second"))]
    pairs: tuple[tuple[int, int], ...] = ()

    @property
    def as_json(self) -> dict[str, Any]:
        """The evidence as files have it."""
        return {"grounded": {"first": self.grounded_1, "second": self.grounded_2}, "pairs": self.pairs}


class Prediction(Record):
    """The answer of an arm to an episode in run `seed`: one of a point x, z, `abstain`, `candidates` and `box`.

    Metres on the floor plane. confidence: of a point, how probable the arm holds it; evidence: what the answer was drawn from,
    for an arm with a map of its own; no verdict depends on either. Keys without a value are left out of files. Raises RecordError
    for a record that has not exactly one of the four.
    """

    schema_id: Literal["ovman-prediction/1"] = Field("ovman-prediction/1", alias="schema")
    episode: Text
    arm: Text
    seed: int
    x: float | None = optional()
    z: float | None = optional()
    confidence: float | None = optional(ge=0, le=1)
    abstain: AbstentionReason | None = optional()
    candidates: tuple[Point, ...] | None = optional()
    box: UniformBox | None = optional()
    evidence: Annotated[Evidence, PlainSerializer(lambda evidence: evidence.as_json)] | None = optional()

    @classmethod
    def of(cls, episode: str, arm: str, seed: int, outcome: Predicted, evidence: Evidence | None = None) -> Self:
        """Return the record of an outcome. seed: the number of the arm's run."""
        form: dict[str, Any]
        match outcome:
            case Answer(x, z, confidence):
                form = {"x": x, "z": z, "confidence": confidence}
            case Abstention(reason):
                form = {"abstain": reason}
            case UniformPick(candidates):
                form = {"candidates": candidates}
            case UniformBox():
                form = {"box": outcome}
        return cls(episode=episode, arm=arm, seed=seed, evidence=evidence, **form)

    @model_validator(mode="after")
    def _of_one_form(self) -> Self:
        forms = [name for name in ("x", "abstain", "candidates", "box") if getattr(self, name) is not None]
        if len(forms) != 1:
            raise ValueError('give exactly one of "x" and "z", "abstain", "candidates", "box"')
        if (self.x is None) != (self.z is None):
            raise ValueError(f"{'x' if self.x is None else 'z'}: the key is missing; a point has x and z")
        return self

    @property
    def outcome(self) -> Predicted:
        """What is predicted."""
        if self.x is not None and self.z is not None:
            return Answer(self.x, self.z, self.confidence)
        if self.abstain is not None:
            return Abstention(self.abstain)
        if self.candidates is not None:
            return UniformPick(self.candidates)
        assert self.box is not None, "a prediction has one form"
        return self.box
