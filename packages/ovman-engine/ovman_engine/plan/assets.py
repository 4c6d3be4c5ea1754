"""Sizes and properties of the assets of houses, by assetId.

Source: the asset database of the pip package ``procthor``. Sizes are those of the box around the unrotated asset, metres.
"""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

MASS_KG = {"CanPickup": 0.5, "Moveable": 10.0}
"""Masses by primary property. The database has none; AI2-THOR's objects weigh about this much."""


@dataclass(frozen=True)
class Asset:
    """One asset of the database."""

    asset_id: str
    type: str
    size: np.ndarray
    """(3,) metres"""
    pickupable: bool
    moveable: bool
    properties: frozenset[str]
    """AI2-THOR's secondary properties: Receptacle, CanOpen, ..."""

    @property
    def mass(self) -> float:
        """Mass in kg; 0 for an asset that does not move."""
        return MASS_KG["CanPickup"] if self.pickupable else MASS_KG["Moveable"] if self.moveable else 0.0


@cache
def _database() -> Mapping[str, Mapping[str, Any]]:
    found = importlib.util.find_spec("procthor")
    if found is None or not found.submodule_search_locations:
        raise FileNotFoundError("the pip package 'procthor' (asset database) is not installed: pip install procthor")
    path = Path(found.submodule_search_locations[0]) / "databases" / "asset-database.json"
    by_type = json.loads(path.read_text())
    return {entry["assetId"]: entry for entries in by_type.values() for entry in entries}


@cache
def asset(asset_id: str) -> Asset:
    """Return the asset `asset_id`, cached. Raises KeyError if the database has none."""
    entry = _database()[asset_id]
    primary = entry.get("primaryProperty")
    return Asset(
        asset_id,
        entry["objectType"],
        np.array([entry["boundingBox"][axis] for axis in "xyz"], dtype=float),
        primary == "CanPickup",
        primary == "Moveable",
        frozenset(entry.get("secondaryProperties", ())),
    )
