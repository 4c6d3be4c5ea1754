"""Finishes are complete and plausible."""

from __future__ import annotations

from ovman_engine import shapes
from ovman_engine.paint import materials, textures
from ovman_engine.plan import floorplan

SCENES = floorplan.names()


def test_every_slot_that_is_drawn_has_a_finish_that_the_camera_knows():
    for name in SCENES[::9]:
        plan = floorplan.load(name)
        for o in plan.objects:
            palette = materials.palette(o, plan)
            for part in shapes.compound(o, plan):
                finish = palette[part.slot]
                assert finish.texture in textures.KINDS
                assert finish.colour.shape == (3,) and (finish.colour >= 0).all() and (finish.colour <= 1).all()
                assert finish.scale_m > 0 and 0 <= finish.gloss <= 1 and 0 <= finish.emission <= 1 and 0 <= finish.seed < 2**31
