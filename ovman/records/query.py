"""What an agent is asked."""

from __future__ import annotations

from dataclasses import dataclass

from ovman.records.relation import Relation


@dataclass(frozen=True, slots=True)
class Query:
    """q = (c, rho): a category and a change relation. The category is "" where the noun is withheld."""

    category: str
    relation: Relation
