"""Finishes: complete, reproducible, plausible, and varied within a type."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest

from ovman_engine import shapes
from ovman_engine.paint import materials, textures
from ovman_engine.plan import floorplan
from ovman_engine.shapes import Part

SCENES = floorplan.names()
RAYS = 6
"""Rays along each edge of a box that find out which parts are on the outside."""


def surface(parts: Sequence[Part], half: np.ndarray) -> Counter[str]:
    """Area, m2, that each slot covers when the parts are looked at from all six sides of their box, `half` (3,) its half extents.

    A part counts as its box. What another part hides, such as the board behind the field of a front, does not count.
    """
    parts = [p for p in parts if p.drawn]
    turns = np.array([p.rotation for p in parts])
    centres, sizes = np.array([p.centre for p in parts]), np.array([p.size for p in parts]) / 2
    cells = (np.stack(np.meshgrid(np.arange(RAYS), np.arange(RAYS)), axis=-1).reshape(-1, 2) + 0.5) / RAYS * 2 - 1
    found: Counter[str] = Counter()
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        starts = np.zeros((len(cells), 3))
        starts[:, others] = cells * half[others]
        origins = (starts - centres[:, None]) @ turns  # (parts, rays, 3), in the frames of the parts
        ways = turns[:, None, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = (-sizes[:, None] - origins) / ways, (sizes[:, None] - origins) / ways
        enters, leaves = np.fmin(*ends).max(axis=2), np.fmax(*ends).min(axis=2)
        met = enters <= leaves
        nearest = np.where(met, enters, np.inf).argmin(axis=0), np.where(met, leaves, -np.inf).argmax(axis=0)
        for first in nearest:
            for part in first[met.any(axis=0)]:
                found[parts[part].slot] += np.prod(2 * half[others]) / len(cells)
    return found


@pytest.fixture(scope="module")
def looks() -> list[tuple[str, str, str, np.ndarray]]:
    """(scene, type, asset or make, display RGB of the slot that covers most of the surface) of every object but floors."""
    found = []
    widest: dict[tuple[str, str], str] = {}
    for name in SCENES:
        plan = floorplan.load(name)
        for o in plan.objects:
            if o.type == "Floor":
                continue
            if (o.type, o.asset_id) not in widest:
                widest[o.type, o.asset_id] = surface(shapes.compound(o, plan), o.box.half).most_common(1)[0][0]
            colour = materials.palette(o, plan)[widest[o.type, o.asset_id]].colour
            found.append((name, o.type, materials.make(o, plan), np.asarray(colour) ** (1 / 2.2)))
    return found


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


@pytest.mark.soak
def test_a_category_comes_in_many_colours(looks):
    """Instances of a type in different scenes differ: their colours spread over the display's range by type and channel."""
    for category in (
        "Chair",
        "SideTable",
        "Vase",
        "Statue",
        "Pillow",
        "GarbageCan",
        "DeskLamp",
        "Sofa",
        "ArmChair",
        "Mug",
        "Book",
    ):
        own = np.array([c for _, t, _, c in looks if t == category])
        assert own.std(axis=0).min() > 0.09, category
