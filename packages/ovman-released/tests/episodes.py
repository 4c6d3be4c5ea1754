"""Released episodes of the smallest floor plan, as they are or changed."""

from __future__ import annotations

from functools import cache
from typing import Any

from settings_of import ROOT

from ovman.records.episode import Episode


@cache
def _all() -> dict[str, Episode]:
    return {one.id: one for one in Episode.load(ROOT / "data" / "ovman-embedded-v6" / "episodes" / "main.jsonl")}


def released(name: str, **changed: Any) -> Episode:
    """The released episode of that id; changed: JSON values of its keys to replace."""
    return Episode.from_json(_all()[name].to_json() | changed)
