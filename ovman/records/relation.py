"""The six change relations of Eq. 1."""

from __future__ import annotations

from enum import StrEnum


class Relation(StrEnum):
    """A relation between an instance and two visits. It selects the referent of a query and says which of its positions
    answers.
    """

    MOVED = "moved"
    FORMER = "former"
    MOVING = "moving"
    STABLE = "stable"
    APPEARED = "appeared"
    REMOVED = "removed"

    @property
    def past(self) -> bool:
        """Whether the answer is a position of visit 1, a place where nothing is any more (R_past)."""
        return self in (Relation.FORMER, Relation.REMOVED)

    @property
    def current(self) -> bool:
        """Whether the answer is a position of visit 2 (R_cur)."""
        return not self.past
