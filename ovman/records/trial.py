"""Candidates, trials, verdicts and certification runs.

A candidate is a scripted change that might make an episode, with its query. A trial is a candidate that was simulated, with
everything that was measured; it judges nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Literal, Self

from pydantic import Field, model_validator

from ovman.records.geometry import Point, Position, Spawn
from ovman.records.record import Count, InstanceId, Length, Name, Record, Text, optional, unless_default
from ovman.records.run import Measured, Travelled
from ovman.records.scene import Alteration, MoverRecord
from ovman.records.task import RecordedWorld, Rejection, Relation
from ovman.records.tour import Tour
from ovman.records.visit import Sighting, VisitPair
from ovman.settings.splits import MAIN, Rules


class Candidate(Record):
    """A candidate: a scripted change, its query and the tours.

    pair: the world pair that it belongs to, which names its random streams; None if it stands alone. split: the split that it is
    drawn for. first, second: the alterations of the untouched scene in each visit. spawn: where the
    run begins. distractor: for STABLE, the instance that moves instead of the target. others: categories of the distractors among
    the alterations, by id. stable: places of the unchanged instances that STABLE queries of the same world pair mean, by id.
    rules: of the split's runs. Files leave out both where they are the paper's. refused: why nothing could be drawn, else None.
    """

    schema_id: Literal["ovman-candidate/2"] = Field("ovman-candidate/2", alias="schema")
    id: Text
    pair: Text | None = optional()
    split: Name = MAIN
    scene: Name
    relation: Relation
    category: Text
    target: Text
    distractor: Text | None
    tours: VisitPair[Tour]
    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    others: Mapping[str, Text]
    spawn: Spawn | None
    stable: Mapping[InstanceId, Point] = unless_default({})
    rules: Rules = unless_default(Rules())
    refused: Rejection | None

    @property
    def streams(self) -> str:
        """Name of its random streams: candidates of a world pair have them in common."""
        return self.id if self.pair is None else self.pair


class Bound(StrEnum):
    """The end of a trial that no setting within the bounds of `measurement` would accept."""

    BEYOND_MEASUREMENT = "beyond_measurement"


class ReachableBox(Record):
    """The box around the cells that the agent can reach: (min, max) of x and of z, metres."""

    x: tuple[float, float]
    z: tuple[float, float]


class Displaced(Record):
    """Positions of a changed instance at the end of each visit, None if it is absent."""

    before: Position | None
    after: Position | None


class TrialMeasurement(Record):
    """Measurements of a trial; missing ones are None and not in files.

    ended: why it ended early, None where it did not. placed: where the simulator put what was placed. spawn_to_box_m:
    from the spawn to the box of the target, None where it is gone in visit 2. spawn_free_moves: quarters
    of a turn in which the spawn can be left. reachable_box: in visit 2. visible_px: mask of the target from nu(a) by pitch.
    visits: names of the recorded tours. sightings: of the category's instances in both tours. world_1, world_2: every present
    instance of the category at the end of each visit, recorded or not. drift_m: farthest distance from the
    placement. movers: of the second tour. other_px: largest mask of each instance of another category that changes, in each tour.
    """

    ended: Rejection | Bound | None
    message: str | None = optional()
    placed: Mapping[str, Position] | None = optional()
    displacement_m: Mapping[str, Length] | None = optional()
    spawn_clearance_m: Mapping[str, Length] | None = optional()
    spawn_to_box_m: Length | None = optional()
    spawn_free_moves: Count | None = optional()
    component_cells: Count | None = optional()
    reachable_box: ReachableBox | None = optional()
    visible_px: Mapping[int, Count] | None = optional()
    answer: Point | None = optional()
    nearest_navigable: Point | None = optional()
    answer_to_navigable_m: Length | None = optional()
    shortest_path_m: Length | None = optional()
    visits: VisitPair[Name] | None = optional()
    sightings: VisitPair[tuple[Sighting, ...]] | None = optional()
    world_1: RecordedWorld | None = optional()
    world_2: RecordedWorld | None = optional()
    changed: Mapping[str, Displaced] | None = optional()
    drift_m: Mapping[str, Length] | None = optional()
    movers: tuple[MoverRecord, ...] = Field((), exclude_if=lambda movers: not movers)
    other_px: Mapping[str, VisitPair[Count]] | None = optional()


class Trial(Record):
    """A trial: the candidate and what was measured."""

    schema_id: Literal["ovman-trial/2"] = Field("ovman-trial/2", alias="schema")
    candidate: Candidate
    measured: TrialMeasurement


class Verdict(Record):
    """The verdict on a trial, "ovman-verdict/1".

    reasons: all against it, in the order of Algorithm 1; rejected: the first of them, None for an admissible trial.
    """

    schema_id: Literal["ovman-verdict/1"] = Field("ovman-verdict/1", alias="schema")
    id: Text
    relation: Relation
    rejected: Rejection | None
    reasons: tuple[Rejection, ...]


class _Judged(Record):
    run: Count
    seed: int
    success: bool


class CertificationRun(Travelled, _Judged):
    """One judged run of the oracle: run 0 is the feasibility run, the others certify. seed: of equal paths and of the mover."""

    @model_validator(mode="after")
    def _stopped(self) -> Self:
        for name in ("answer_distance_m", "navigable_distance_m"):
            if self.success and getattr(self, name) is None:
                raise ValueError(f"{name} is None; a run that succeeds has stopped")
        return self


class _Numbered(Record):
    run: Count
    seed: int


class OracleRun(Measured, _Numbered):
    """One run of the oracle as it was measured."""


class Certification(Record):
    """The oracle's runs on one trial, "ovman-certification/1"."""

    schema_id: Literal["ovman-certification/1"] = Field("ovman-certification/1", alias="schema")
    id: Text
    runs: tuple[OracleRun, ...]


class Admission(Record):
    """A trial that some setting of the thresholds admits, "ovman-admission/1".

    settings: numbers of the admitting settings, ascending; 0 is the setting in force, k the k-th of section `sensitivity`.
    released: whether the trial is among the released episodes.
    """

    schema_id: Literal["ovman-admission/1"] = Field("ovman-admission/1", alias="schema")
    id: Text
    settings: tuple[Count, ...]
    released: bool
