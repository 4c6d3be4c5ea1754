"""Definitions that the paper leaves open, and the arms of each reading."""

from __future__ import annotations

from ovman.report.statements.statement import Other, Readings

PAST = ("former", "removed")
CURRENT = ("moved", "moving", "stable", "appeared")
_HANDED = ("grounding_two", "grounding_maintained", "grounding_dualmap_one", "grounding_dualmap_two")
ANY, NEAREST, PLACES = (
    Other({f"static.{row}": f"static.{row}_{name}" for row in _HANDED}) for name in ("any", "nearest", "places")
)

GROUNDING = Readings(
    definition="of the objects of its own map an agent is handed those most of whose detections truly show the category "
    "(majority), those with one such detection (any), the one nearest to each true place (nearest), or all within R of a place "
    "at which either tour recorded the category (places)",
    own="majority",
    others={"any": ANY, "nearest": NEAREST, "places": PLACES},
)
ONE_READING = Readings(
    definition="what one reading is, one map that is maintained through both visits or a single visit, which answers a past "
    "relation with a place in the reachable box; and which objects of its map an agent is handed",
    own="one maintained map, majority",
    others={
        "any": ANY,
        "nearest": NEAREST,
        "places": PLACES,
        "a single visit": Other({"static.grounding_maintained": "static.grounding_one"}),
    },
)
