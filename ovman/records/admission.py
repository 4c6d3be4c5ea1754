"""Under which settings of the thresholds a trial is admissible, "ovman-admission/1"."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ovman.records.record import Count, Record, Text


class Admission(Record):
    """A trial that some setting admits. settings: numbers of those that do, rising; 0 is the setting in force, k the k-th of
    section `sensitivity`. released: whether it is among the released episodes.
    """

    schema_id: Literal["ovman-admission/1"] = Field("ovman-admission/1", alias="schema")
    id: Text
    settings: tuple[Count, ...]
    released: bool
