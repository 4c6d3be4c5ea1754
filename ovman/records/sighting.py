"""What a tour truly recorded of instances. Diagnostic arms are handed it; no other arm sees it."""

from __future__ import annotations

from typing import Generic, Literal, TypeVar

from pydantic import Field

from ovman.records.record import Count, Record, Text

T = TypeVar("T")


class Sighting(Record):
    """One instance in one view of a tour: size of its mask in pixels, and its floor-plane position in metres at that view."""

    view: Count
    instance: Text
    px: Count
    x: float
    z: float


class VisitPair(Record, Generic[T]):
    """Something of the two visits of an episode."""

    first: T
    second: T

    def __getitem__(self, which: str) -> T:
        """Of the visit "first" or "second". KeyError for another name."""
        if which not in ("first", "second"):
            raise KeyError(f"{which!r} is no visit; the visits are first and second")
        made: T = getattr(self, which)
        return made


class Sightings(Record):
    """The sightings of the instances of an episode's category in both tours, "ovman-sightings/1"."""

    schema_id: Literal["ovman-sightings/1"] = Field("ovman-sightings/1", alias="schema")
    episode: Text
    sightings: VisitPair[tuple[Sighting, ...]]
