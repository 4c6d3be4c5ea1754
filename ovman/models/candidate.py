"""A candidate, "ovman-candidate/1": a scripted change that might make an episode, and what is asked about it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ovman.models.change import Alteration
from ovman.models.geometry import Spawn
from ovman.models.record import Record, Text
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.settings.splits import MAIN


class Candidate(Record):
    """A candidate. split: what it is drawn for. first, second: what differs from the untouched scene in each visit. spawn: where
    the run begins.

    distractor: the instance that is moved in place of the target, for STABLE. refused: why nothing could be drawn, else None.
    """

    schema_id: Literal["ovman-candidate/1"] = Field("ovman-candidate/1", alias="schema")
    id: Text
    split: Text = MAIN
    scene: Text
    relation: Relation
    category: Text
    target: Text
    distractor: Text | None
    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    spawn: Spawn | None
    refused: Rejection | None
