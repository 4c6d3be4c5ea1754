"""Forms: one table takes an object's type to a compound of parts fitted to its oriented box, for drawing and for collision alike."""

from __future__ import annotations

from ovman.engine.floorplan import FloorPlan, SimObject
from ovman.engine.shapes.collision import collision
from ovman.engine.shapes.part import Part
from ovman.engine.shapes.tessellation import mesh

__all__ = ["Part", "collision", "compound", "mesh"]


def compound(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Parts of `obj` in the frame of its oriented box: origin at its centre, metres. Deterministic in the asset and its surroundings."""
    size = 2 * obj.box.half
    return (Part("box", (0.0, 0.0, 0.0), size.clip(1e-4), bevel=min(0.01, float(size.min()) * 0.2)),)
