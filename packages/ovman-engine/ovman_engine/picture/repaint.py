"""Random finishes, colours and lights of a scene. Depth and instance ids do not change.

A scene's own finishes are drawn from its name, so another name gives other finishes by the same rules: built-in furniture still
matches, and materials stay plausible.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ovman_engine.paint.decor import Decor, Lighting
from ovman_engine.paint.materials import Material, palette
from ovman_engine.picture.lights import Rig
from ovman_engine.picture.painter import Appearance
from ovman_engine.picture.scene_mesh import PlanMeshes, structures
from ovman_engine.plan.floorplan import FloorPlan
from ovman_engine.room.room import Room
from ovman_engine.shapes.style import Style

MIN_COLOUR = 0.02
"""Least linear component of a drawn colour: a black object would look like a hole."""


def finishes(plan: FloorPlan, room: Room, key: str) -> dict[str, Mapping[str, Material]]:
    """Palette of every instance of `plan` and every structure of `room`, by name, as if the scene had another name."""
    renamed = replace(plan, name=f"{plan.name}~{key}")
    out = {o.object_id: palette(o, renamed) for o in plan.objects}
    out.update({name: colours for name, _, colours in structures(renamed, replace(room, plan=renamed))})
    return out


def recoloured(material: Material, key: str) -> Material:
    """Return the material in a colour drawn from `key`, with its own texture, gloss and emission."""
    style = Style(key)
    return replace(material, colour=np.array([style.uniform(channel, MIN_COLOUR, 0.9) ** 1.5 for channel in "rgb"]))


def looks(meshes: PlanMeshes, room: Room, decor: Decor) -> Appearance:
    """Materials of all instances under `decor`, in the order of `meshes.materials`."""
    materials = meshes.materials
    if decor.finishes:
        materials = meshes.repainted(finishes(meshes.plan, room, decor.finishes))
    if decor.colours:
        materials = tuple(recoloured(m, f"{decor.colours}|{k}") for k, m in enumerate(materials))
    return Appearance.of(materials)


def _rgb(hue: float, saturation: float) -> np.ndarray:
    """RGB (3,) of an HSV colour of value 1."""
    ramp = np.clip(np.abs((hue * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return 1.0 - saturation * (1.0 - ramp)


def relit(rig: Rig, lighting: Lighting) -> Rig:
    """Return the rig with random intensities and colours; ambient light follows."""
    table = rig.lights.copy()
    for k in range(len(table)):
        style = Style(lighting.key if lighting.synchronized else f"{lighting.key}|{k}")
        colour = table[k, 3:6].copy()
        if lighting.tinted:
            tint = _rgb(style.uniform("hue", *lighting.hue), style.uniform("saturation", *lighting.saturation))
            colour = float(colour.max()) * tint
        table[k, 3:6] = colour * style.uniform("brightness", *lighting.brightness)
    before, after = rig.lights[:, 3:6].sum(axis=0), table[:, 3:6].sum(axis=0)
    return replace(rig, lights=table, ambient=rig.ambient * (after / np.maximum(before, 1e-9)).astype(np.float32))
