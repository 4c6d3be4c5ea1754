"""A candidate, "ovman-candidate/2": a scripted change that might make an episode, and what is asked about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field

from ovman.models.change import Alteration
from ovman.models.geometry import Spawn
from ovman.models.record import Name, Record, Text
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.settings.splits import MAIN
from ovman.models.sighting import VisitPair
from ovman.models.tour import Tour


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
