"""Actions that change the appearance of a scene: materials, colours and lights."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ovman_engine.actions.registry import Thrown, action, out_of_range
from ovman_engine.client.session import SCENE_SUFFIX, Session
from ovman_engine.paint.decor import Decor, Lighting, Range

ROOM_TYPES = {
    "kitchen": "Kitchen",
    "livingroom": "LivingRoom",
    "bedroom": "Bedroom",
    "bathroom": "Bathroom",
    "robothor": "RoboTHOR",
}
"""Type of room as AI2-THOR compares it -> as it reports it."""
LAST_TRAINING, LAST_VALIDATION = 20, 25
"""Last of the 30 scenes of each type that belong to training and to validation; the later ones are test scenes."""
POOLS = ("train", "val", "test", "external")


def _drawn(session: Session, what: str) -> str:
    """Key of the next random draw: a function of the seed and of the number of earlier draws."""
    session.draws += 1
    return f"{what}|{session.seed}|{session.draws}"


def _redecorate(session: Session, **changes: Any) -> None:
    session.change(decor=replace(session.settings.decor, **changes))


def _split(scene: str) -> str | None:
    """Return the split that `scene` belongs to; None for a house."""
    digits = scene.removesuffix(SCENE_SUFFIX).removeprefix("FloorPlan")
    if not digits.isdigit():
        return None
    number = int(digits) % 100
    return "train" if number <= LAST_TRAINING else "val" if number <= LAST_VALIDATION else "test"


def _room_types(session: Session, asked: list[str] | None) -> list[str]:
    if asked is None:
        return list(ROOM_TYPES)
    if not asked:
        raise Thrown("ArgumentException", "inRoomTypes must have a non-zero length!")
    for name in asked:
        if name.lower() not in ROOM_TYPES:
            known = ", ".join(f'"{shown}"' for shown in ROOM_TYPES.values())
            raise Thrown(
                "ArgumentException", f"inRoomTypes contains unknown room type: {name}.\nValid room types include {{{known}}}"
            )
    chosen = list(dict.fromkeys(name.lower() for name in asked))
    own = session.world.plan.kind.replace("_", "")
    if own in ROOM_TYPES and own not in chosen:
        scene = session.scene_name
        raise Thrown("ArgumentException", f'inRoomTypes must include "{own}" inside of a {own} scene: {scene}.')
    return chosen


@action("RandomizeMaterials")
def randomize_materials(
    session: Session,
    useTrainMaterials: bool | None = None,
    useValMaterials: bool | None = None,
    useTestMaterials: bool | None = None,
    useExternalMaterials: bool | None = None,
    inRoomTypes: list[str] | None = None,
) -> dict[str, Any]:
    """RandomizeMaterials (contract, section 4).

    Finishes are drawn by rule, not from lists; the lists asked for are part of the draw's key.
    """
    chosen, split = _room_types(session, inRoomTypes), _split(session.scene_name)
    asked = dict(zip(POOLS, (useTrainMaterials, useValMaterials, useTestMaterials, useExternalMaterials), strict=True))
    if split is not None and asked[split] is False:
        name = f"use{split.capitalize()}Materials"
        raise Thrown("ArgumentException", f"Inside of RandomizeMaterials, cannot set {name}=false inside of a {split} scene.")
    own = {split, "external"} if split == "train" else {split} if split else set(POOLS)
    used = {pool: pool in own if wish is None else wish for pool, wish in asked.items()}
    pools = "+".join(pool for pool, yes in used.items() if yes)
    _redecorate(session, finishes=_drawn(session, pools))
    return {
        "chosenRoomTypes": chosen,
        **{f"use{pool.capitalize()}Materials": yes for pool, yes in used.items()},
        "totalMaterialsConsidered": len(session.world.plan.objects) * sum(used.values()),
    }


@action("ResetMaterials")
def reset_materials(session: Session) -> None:
    """ResetMaterials: restores the materials of the scene, and with them its colours."""
    _redecorate(session, finishes=Decor.finishes, colours=Decor.colours)


@action("RandomizeColors")
def randomize_colors(session: Session) -> None:
    """RandomizeColors: draws other colours for the materials of the scene."""
    _redecorate(session, colours=_drawn(session, "colours"))


@action("ChangeColorOfMaterials")
def change_color_of_materials(session: Session) -> None:
    """ChangeColorOfMaterials: the former name of RandomizeColors."""
    randomize_colors(session)


@action("ResetColors")
def reset_colors(session: Session) -> None:
    """ResetColors: restores the colours."""
    _redecorate(session, colours=Decor.colours)


@action("RandomizeLighting")
def randomize_lighting(
    session: Session,
    synchronized: bool = False,
    brightness: list[float] | None = None,
    randomizeColor: bool = True,
    hue: list[float] | None = None,
    saturation: list[float] | None = None,
) -> None:
    """RandomizeLighting: draws brightness and, if `randomizeColor`, hue and saturation of each light within the given ranges.

    `synchronized` gives all lights the same colour and brightness.
    """
    for name, given in (("hue", hue), ("saturation", saturation)):
        if not randomizeColor and given is not None:
            raise Thrown("ArgumentException", f"Cannot pass in randomizeColor=False while also providing {name}={given}.")
    ranges = {
        "saturation": Lighting.saturation if saturation is None else tuple(saturation),
        "hue": Lighting.hue if hue is None else tuple(hue),
        "brightness": Lighting.brightness if brightness is None else tuple(brightness),
    }
    if any(len(r) != 2 for r in ranges.values()):
        shown = ", ".join(f"{name}={list(r)}" for name, r in ranges.items())
        raise Thrown(
            "ArgumentException", f"Ranges for hue, saturation, and brightness must each have 2 values. You gave {shown}."
        )
    if min(ranges["brightness"]) < 0:
        raise out_of_range(f"Each brightness must be >= 0, not brightness={list(ranges['brightness'])}.")
    for name in ("hue", "saturation"):
        if not 0 <= min(ranges[name]) <= max(ranges[name]) <= 1:
            raise out_of_range(f"{name} range must be in [0:1], not {list(ranges[name])}")
    ordered: dict[str, Range] = {name: (min(r), max(r)) for name, r in ranges.items()}
    _redecorate(
        session, lighting=Lighting(_drawn(session, "lighting"), synchronized=synchronized, tinted=randomizeColor, **ordered)
    )


@action("ResetLighting")
def reset_lighting(session: Session) -> None:
    """ResetLighting: restores the lights of the scene."""
    _redecorate(session, lighting=None)
