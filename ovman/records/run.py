"""Records of runs: what is measured of an agent from its spawn to its end, and what the judge makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field

from ovman.records.geometry import Spawn
from ovman.records.record import Count, Length, Record, Text, optional
from ovman.records.task import Measurement

Outcome = Literal["stopped", "abstained", "budget", "stalled"]
"""How a run ends: the agent stopped or abstained, its actions ran out, or it made no successful move for too long."""


class InstanceTerms(Record):
    """The terms of Eq. 4 of one instance at a stop, for an agent whose own task is to reach any of its category."""

    box_distance_m: Length
    visible_px: Mapping[int, Count]


class Terms(Record):
    """The terms of Eq. 4 at a stop; None if the run did not stop. Metres, degrees, pixels by pitch.

    rival_distance_m: from the stop to the nearest rival (`task.rivals`). Only runs whose success is exclusive have it.
    """

    stop: Spawn | None
    box_distance_m: Length | None
    answer_distance_m: Length | None
    navigable_distance_m: Length | None
    visible_px: Mapping[int, Count] | None
    rival_distance_m: Length | None = optional()

    @property
    def measurement(self) -> Measurement:
        """The terms of a run that stopped. ValueError for one that did not."""
        if self.answer_distance_m is None or self.navigable_distance_m is None:
            raise ValueError("a run that did not stop has no measurement")
        return Measurement(
            self.box_distance_m, self.answer_distance_m, self.navigable_distance_m, self.visible_px, self.rival_distance_m
        )


NOWHERE = Terms(stop=None, box_distance_m=None, answer_distance_m=None, navigable_distance_m=None, visible_px=None)
"""The terms of a run that did not stop."""


class Travelled(Terms):
    """Terms, and how far the agent came: metres travelled and number of primitives."""

    path_length_m: Length
    actions: Count


class _Ended(Record):
    outcome: Outcome


class Measured(Travelled, _Ended):
    """Measurements of a run.

    instances: terms of every instance of the category by id, for an arm that is judged on its own task, too. path_at_m: path
    length in metres by the number of actions, at the budgets where other arms cut the run. Files leave out both where they are
    None.
    """

    instances: Mapping[str, InstanceTerms] | None = optional()
    path_at_m: Mapping[int, Length] | None = optional()


class _OfEpisode(Record):
    schema_id: Literal["ovman-run/1"] = Field("ovman-run/1", alias="schema")
    episode: Text
    arm: Text
    seed: int


class Rollout(Measured, _OfEpisode):
    """One run of an arm on an episode under one seed, "ovman-run/1", measured and not judged.

    trace: all that the agent did, a letter an action: F forward, L and R turns, S stop, A abstain. None where it was not kept.
    """

    trace: str | None = optional(pattern="^[FLR]*[SA]?$")


class Score(Rollout):
    """A rollout with its verdict: success (Eq. 4), SPL (Eq. 5), and success on the arm's own task if it has one."""

    success: bool
    spl: float = Field(ge=0, le=1)
    own_success: bool | None = optional()
