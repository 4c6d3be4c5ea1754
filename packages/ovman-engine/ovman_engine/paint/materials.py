"""Materials of an instance's palette slots, drawn from a hash of its asset and its scene.

The type gives the substance (`substances`); the asset and the scene give the tone. A floor plan is part of the key because many
assets occur in all of them: painted alike everywhere, colour would name them. An asset of a house looks the same in every house,
whatever else there is. Built-in objects match: cabinet fronts, window frames, basins and counters of one scene share a make.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from ovman_engine.paint import finishes
from ovman_engine.paint.finishes import Material, linear
from ovman_engine.paint.substances import COMMON, finish
from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.shapes import surroundings
from ovman_engine.shapes.style import Style

__all__ = ["Material", "linear", "make", "palette"]

MAKES = {
    "Cabinet": "cabinetry",
    "Drawer": "cabinetry",
    "CounterTop": "counter",
    "Shelf": "shelves",
    "Window": "windows",
    "Blinds": "blinds",
    "Curtains": "curtains",
    "StoveBurner": "stove",
    "StoveKnob": "stove",
    "ShowerDoor": "shower",
    "ShowerGlass": "shower",
    "SinkBasin": "basins",
    "BathtubBasin": "tub",
    "Bathtub": "tub",
}
"""Types without assets of their own -> the make that all of them in a scene share."""
RELATED = {"second": ("main", 0.6), "cloth_second": ("cloth", 0.8), "leaf_second": ("leaf", 1.0)}
"""Slot -> (slot with which it often shares its substance, how often). They then differ slightly in lightness."""
OWN = frozenset(
    {
        "Bed",
        "Painting",
        "Poster",
        "Lettuce",
        "Bread",
        "DishSponge",
        "Potato",
        "Statue",
        "StoveBurner",
        "Stove",
        "Sink",
        "Spoon",
        "PaperTowelRoll",
        "ToiletPaper",
        "Laptop",
        "RemoteControl",
        "TableTopDecor",
        "LightSwitch",
    }
)
"""Types whose parts differ in substance."""
_SHADE = 0.16
_APART = 0.1
"""Range of lightness among instances of one asset in a scene."""
_KEPT = 8
_REPEATS: OrderedDict[int, tuple[FloorPlan, Counter]] = OrderedDict()


def _shaded(material: Material, share: float) -> Material:
    return replace(material, colour=np.clip(material.colour * (1.0 + share), 0.0, 0.95))


class _Slots(Mapping):
    """Materials by slot, made when they are first needed: few objects have parts of every slot."""

    def __init__(self, make: Callable[[str], Material]) -> None:
        self._make = make
        self._made: dict[str, Material] = {}

    def __getitem__(self, slot: str) -> Material:
        if slot not in self._made:
            if slot not in COMMON:
                raise KeyError(slot)
            self._made[slot] = self._make(slot)
        return self._made[slot]

    def __iter__(self) -> Iterator[str]:
        return iter(COMMON)

    def __len__(self) -> int:
        return len(COMMON)


def _painted(key: str, kind: str, in_house: bool = False) -> Mapping[str, Material]:
    whole = Style(key)

    def make(slot: str) -> Material:
        style = Style(f"{key}|{slot}")
        other, often = RELATED.get(slot, ("", 0.0))
        if other and kind not in OWN and whole.chance(f"{slot} as {other}", often):
            return _shaded(made[other], style.choice("sign", (-1, 1)) * style.uniform("shade", 0.5, 1.5) * _SHADE)
        return replace(finish(kind, slot, in_house)(style), seed=style.integer("seed") % 2**31)

    made = _Slots(make)
    return made


def _repeats(plan: FloorPlan) -> Counter:
    kept, found = _REPEATS.get(id(plan), (None, Counter()))
    if kept is not plan:
        found = Counter(o.asset_id for o in plan.objects if o.asset_id)
        _REPEATS[id(plan)] = (plan, found)
        while len(_REPEATS) > _KEPT:
            _REPEATS.popitem(last=False)
    return found


def _scene(plan: FloorPlan) -> str:
    """Return the name of the scene in the keys of finishes: one for all houses, and the key of RandomizeMaterials, if any."""
    return plan.name if plan.house is None else "home" + plan.name.removeprefix(plan.house.name)


def _maker(obj: SimObject, plan: FloorPlan) -> tuple[str, str]:
    """Key of the finish of `obj`, and the type that gives its substance."""
    if obj.asset_id:
        return f"{_scene(plan)}|{obj.asset_id}", "Basin" if obj.type == "Sink" and plan.kind == "bathroom" else obj.type
    owner = surroundings.host(obj, plan)
    if owner is not None:
        return _maker(owner, plan)
    kind = "Basin" if obj.type in ("Sink", "SinkBasin") and plan.kind == "bathroom" else obj.type
    return f"{plan.name}|{MAKES.get(obj.type, obj.name)}", kind


def make(obj: SimObject, plan: FloorPlan) -> str:
    """Key of the finish of `obj`: its asset, the furniture it is set into, the scene's make, or its name."""
    return _maker(obj, plan)[0]


def palette(obj: SimObject, plan: FloorPlan, kind: str | None = None) -> Mapping[str, Material]:
    """Material of every slot of `obj`: a function of scene and asset, and of the instance if its asset repeats in a floor plan.

    `kind`: type that gives the substance, if not its own: a stove takes its finish from its burner.
    """
    key, own_kind = _maker(obj, plan)
    kind = kind or own_kind
    usual = _painted(key, kind, plan.house is not None)
    instead: dict[str, Callable[[], Material]] = {}
    if kind == "Floor":
        style = Style(f"{plan.name}|floor{obj.asset_id}")
        instead["main"] = lambda: replace(finishes.floor(style), seed=style.integer("seed") % 2**31)
    if kind == "CounterTop":
        instead["second"] = lambda: _painted(f"{plan.name}|{MAKES['Cabinet']}", "Cabinet")["main"]
    if obj.type == "Sink":
        basin = "Basin" if kind == "Basin" else "SinkBasin"
        instead["main"] = lambda: _painted(f"{plan.name}|{MAKES['SinkBasin']}", basin)["metal"]
    repeats = plan.house is None and obj.asset_id and _repeats(plan)[obj.asset_id] > 1
    own = Style(f"{plan.name}|{obj.name}") if repeats else None

    def make(slot: str) -> Material:
        made = instead[slot]() if slot in instead else usual[slot]
        if own is None or made.emission != 0.0:
            return made
        return replace(_shaded(made, own.uniform("apart", -_APART, _APART)), seed=own.integer(slot) % 2**31)

    return _Slots(make)
