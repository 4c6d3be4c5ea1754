"""A candidate, "ovman-candidate/2": a scripted change that might make an episode, and what is asked about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field

from ovman.records.change import Alteration
from ovman.records.geometry import Spawn
from ovman.records.record import Name, Record, Text
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.records.sighting import VisitPair
from ovman.records.tour import Tour
from ovman.settings.splits import MAIN


class Candidate(Record):
    """A candidate. split: what it is drawn for. tours: of the visits. first, second: what differs from the untouched scene in
    each. spawn: where the run begins.

    distractor: the instance that is moved in place of the target, for STABLE. others: the categories, all but the queried one, of
    the instances in `first` and `second` that change for no query, by their ids. refused: why nothing could be drawn, else None.
    """

    schema_id: Literal["ovman-candidate/2"] = Field("ovman-candidate/2", alias="schema")
    id: Text
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
    refused: Rejection | None
