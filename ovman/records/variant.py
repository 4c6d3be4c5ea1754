"""Variants of a split: which of what it adds to the paper's protocol is in force."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum


class Setting(StrEnum):
    """What a split may add to the paper's protocol; as its entry in section `splits` names it."""

    OTHERS = "others"
    SECOND_TOUR = "second_tour"
    LIGHT = "light"
    SENSORS = "sensors"


VARIANTS: Mapping[str, frozenset[Setting]] = {
    "none": frozenset(),
    **{setting.value: frozenset({setting}) for setting in Setting},
    "all": frozenset(Setting),
}
"""The settings in force in each variant, by its name: none, each alone, all."""
