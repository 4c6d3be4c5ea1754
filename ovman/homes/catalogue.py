"""The furniture of homes: assets, groups of assets and rules of the package ``procthor``, in millimetres.

Source: the databases of the pip package ``procthor`` 0.0.1.dev2: assets, placement annotations, receptacles, asset groups,
materials. Nothing of them is repeated here.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

DATABASES = files("procthor") / "databases"
LOOKS = Path(__file__).with_name("looks.json")
"""Pairs of assets that look alike"""
SPLITS = ("train", "val", "test")
LARGE_MM = (300, 200)
"""A large thing is at least so long along its longest side, and along its second longest."""
LOOSE_MM, LOOSE_MM2 = 2100, 1_300_000
"""A loose thing is at most so long, and covers at most so much floor. Two of them fit into any room."""


@dataclass(frozen=True)
class Asset:
    """One asset. width, height, depth: the box around it along x, y, z at yaw 0, rounded up, millimetres."""

    id: str
    category: str
    width: int
    height: int
    depth: int
    movable: bool
    """Whether the simulator can move it or pick it up"""

    @property
    def large(self) -> bool:
        """Whether a robot sees it from across a room."""
        shortest, second, longest = sorted((self.width, self.height, self.depth))
        return longest >= LARGE_MM[0] and second >= LARGE_MM[1]

    @property
    def loose(self) -> bool:
        """Whether it is large, movable, and small enough to stand somewhere else."""
        fits = max(self.width, self.height, self.depth) <= LOOSE_MM and self.width * self.depth <= LOOSE_MM2
        return self.large and self.movable and fits


@dataclass(frozen=True)
class Part:
    """One asset of a group, next to or on top of another part, its `parent`, which is an earlier part (None for the first).

    side: the side of the parent's box, along x and z, from which `offset` (x, z), millimetres, is measured: -1, 0 (middle) or 1.
    align: what of its own box lies there: 1 the lower side, 0 the middle, -1 the upper side. Parts of one `name` are one asset.
    """

    category: str
    assets: frozenset[str]
    parent: int | None
    above: bool
    side: tuple[int, int]
    align: tuple[int, int]
    offset: tuple[int, int]
    yaw_deg: int
    jitter_deg: int
    name: str


@dataclass(frozen=True)
class Group:
    """Assets that stand together. weights: how often it is chosen, by kind of room. middle: whether it may stand free."""

    name: str
    parts: tuple[Part, ...]
    weights: Mapping[str, int]
    middle: bool


@cache
def database(name: str) -> Any:
    """Return a database of ``procthor`` by the path of its file."""
    return json.loads((DATABASES / name).read_text(encoding="utf-8"))


@cache
def assets(category: str, split: str) -> tuple[Asset, ...]:
    """Return the assets of a category in a split, in the database's order. Assets without a split belong to train."""
    found = [e for e in database("asset-database.json").get(category, ()) if (e["split"] or "train") == split]
    return tuple(_asset(entry) for entry in found)


def _asset(entry: Mapping[str, Any]) -> Asset:
    width, height, depth = (2 * math.ceil(500 * entry["boundingBox"][axis]) for axis in "xyz")
    movable = entry.get("primaryProperty") in ("Moveable", "CanPickup")
    return Asset(entry["assetId"], entry["objectType"], width, height, depth, movable)


@cache
def weight(category: str, kind: str) -> int:
    """Return how usual a category is in a kind of room: 0 never, 1, 2 often."""
    return int(database("placement-annotations.json")[f"in{kind}s"].get(category) or 0)


@cache
def may(category: str, place: str) -> bool:
    """Return whether a category may stand at a place: onFloor, inCorner, inMiddle, onEdge; or multiplePerRoom."""
    return bool(database("placement-annotations.json")[place].get(category))


@cache
def categories() -> tuple[str, ...]:
    """All categories, sorted."""
    return tuple(sorted(database("asset-database.json")))


def contents(receptacle: str) -> Mapping[str, float]:
    """Return how often a receptacle of a category holds things of others, by their category."""
    return {k: v["p"] for k, v in sorted(database("receptacles.json").get(receptacle, {}).items())}


@cache
def groups() -> tuple[Group, ...]:
    """Return the groups of assets, sorted by name."""
    names = sorted(path.name for path in (DATABASES / "asset_groups").iterdir())
    return tuple(_group(name.removesuffix(".json")) for name in names if name.endswith(".json"))


def _group(name: str) -> Group:
    given = database(f"asset_groups/{name}.json")
    order: list[int] = []
    stack = list(given["treeData"])
    while stack:
        node = stack.pop(0)
        order.append(node["instanceId"])
        stack += node.get("children", ())
    order.sort(key=lambda k: "parentInstanceId" in given["assetMetadata"][str(k)])
    parents = {k: given["assetMetadata"][str(k)].get("parentInstanceId") for k in order}
    order.sort(key=lambda k: 0 if parents[k] is None else 1 + (parents[parents[k]] is not None))
    parts = tuple(_part(given["assetMetadata"][str(k)], order) for k in order)
    rules = given["groupProperties"]
    weights = {kind[0].upper() + kind[1:-1]: value for kind, value in rules["roomWeights"].items()}
    return Group(name, parts, weights, rules["location"]["middle"])


def _part(given: Mapping[str, Any], order: list[int]) -> Part:
    at = given["position"]
    row, column = divmod(at["relativeAnchorToParent"], 3)
    parent = given.get("parentInstanceId")
    (category,) = given["assetIds"]
    # The database mirrors x: its columns run from +x to -x.
    return Part(
        category,
        frozenset(given["assetIds"][category]),
        None if parent is None else order.index(parent),
        at["verticalAlignment"] == "above",
        (1 - column, row - 1),
        (at["xAlignment"] - 1, at["zAlignment"] - 1),
        (0, 0) if parent is None else (-round(1000 * at["x"]), round(1000 * at["z"])),
        round(given["rotation"]),
        round(given["randomness"]["dtheta"]),
        given["name"],
    )


@cache
def _alike() -> frozenset[frozenset[str]]:
    table = json.loads(LOOKS.read_text(encoding="utf-8"))
    return frozenset(frozenset(pair) for pairs in table.values() for pair in pairs)


def looks_different(first: str, second: str) -> bool:
    """Return whether two assets of one category and split can be told apart in pictures (training/looks.py)."""
    return first != second and frozenset((first, second)) not in _alike()
