"""The oracle's runs that certify an episode."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from ovman.records.record import Count, Record, Text
from ovman.records.run import Measured, Travelled


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
