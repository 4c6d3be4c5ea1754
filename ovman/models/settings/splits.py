"""Section `splits`: what is released beside the benchmark's own split, whose episodes have one change each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, field_validator

from ovman.models.settings.benchmark import PerRelation
from ovman.models.settings.values import Listed, Section, Some, Whole

MAIN = "main"
"""The split of section `benchmark`."""


class Split(Section):
    """A split whose pairs of tours have several changes each, of instances of one category, and serve several queries."""

    name: str = Field(description="the key of its entry, in file names and ids")
    changes: Annotated[tuple[Annotated[Whole, Field(ge=2, le=3)], ...], Listed, Field(min_length=1)] = Field(
        description="how many instances of the queried category change in a pair of tours, each under another relation"
    )
    episodes: PerRelation = Field(description="episodes released per relation")
    draws: PerRelation = Field(description="candidates per relation and scene")
    tries: Some = Field(
        description="how often a relation chooses at most what changes in a scene, for each candidate that is asked for"
    )
    arms: Annotated[tuple[str, ...], Listed] = Field(description="static arms that answer its queries")

    @field_validator("changes", "arms")
    @classmethod
    def _distinct(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        if len(set(values)) < len(values):
            raise ValueError("one of them is there twice")
        return values


def _named(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    for name in value:
        if name == MAIN or not re.fullmatch(r"[a-z]+", str(name)):
            raise ValueError(f"{name!r} cannot name a split; write small letters, not {MAIN}, which is that of section benchmark")
    return {
        name: entry | {"name": name} if isinstance(entry, dict) else entry for name, entry in value.items() if entry is not None
    }


Splits = Annotated[dict[str, Split], BeforeValidator(_named)]
"""By name; an entry that is null is left out."""


def splits_of(splits: Mapping[str, Split]) -> tuple[str, ...]:
    """The names of all splits, the benchmark's own first."""
    return MAIN, *splits
