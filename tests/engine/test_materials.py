"""Finishes: complete, reproducible, and silent about what a thing is."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from ovman.engine import floorplan, materials, shapes, textures

SCENES = floorplan.names()


@pytest.fixture(scope="module")
def looks() -> list[tuple[str, str, str, np.ndarray]]:
    """(scene, type, asset or make, display RGB of the slot that covers most) of every object but floors."""
    found = []
    widest: dict[tuple[str, str], str] = {}
    for name in SCENES:
        plan = floorplan.load(name)
        for o in plan.objects:
            if o.type == "Floor":
                continue
            if (o.type, o.asset_id) not in widest:
                area: Counter = Counter()
                for part in shapes.compound(o, plan):
                    if part.drawn:
                        x, y, z = part.size
                        area[part.slot] += x * y + y * z + z * x
                widest[o.type, o.asset_id] = area.most_common(1)[0][0]
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


def test_a_palette_is_the_same_when_it_is_drawn_again():
    plan = floorplan.load("FloorPlan201")
    for o in plan.objects:
        first, again = materials.palette(o, plan), materials.palette(o, plan)
        assert all(np.array_equal(first[s].colour, again[s].colour) and first[s].seed == again[s].seed for s in first)


def test_instances_of_one_asset_differ_a_little_and_assets_more():
    plan = floorplan.load("FloorPlan230")
    repeated = [a for a, n in Counter(o.asset_id for o in plan.objects if o.asset_id).items() if n > 1]
    assert repeated
    for asset in repeated:
        colours = [materials.palette(o, plan)["main"].colour for o in plan.objects if o.asset_id == asset]
        spread = max(np.abs(a - b).max() for a in colours for b in colours)
        assert 0 < spread < 0.25


def test_the_same_asset_is_painted_anew_in_every_scene():
    seen: dict[str, list[np.ndarray]] = {}
    for name in SCENES:
        plan = floorplan.load(name)
        for o in plan.objects:
            if o.asset_id and o.type in ("Mug", "Pen", "CD", "TissueBox"):
                seen.setdefault(o.asset_id, []).append(materials.palette(o, plan)["main"].colour)
    for colours in seen.values():
        assert len({tuple(np.round(c, 4)) for c in colours}) > 0.9 * len(colours) or len(colours) < 5


def test_drawers_match_the_furniture_that_they_belong_to():
    matched = 0
    for name in SCENES[30:60]:
        plan = floorplan.load(name)
        for o in plan.objects:
            owner = materials.surroundings.host(o, plan)
            if owner is not None:
                matched += 1
                assert materials.make(o, plan) == materials.make(owner, plan)
    assert matched > 20


def test_colour_does_not_give_the_category_away(looks):
    """Nearest neighbour in colour among other scenes: no better at naming the type than shuffled labels, within 3 points.

    Types with at least 30 instances; leaves are foliage-coloured, so house plants may add a little.
    """
    common = {t for t, n in Counter(t for _, t, _, _ in looks).items() if n >= 30}
    rows = [(scene, t, make, c) for scene, t, make, c in looks if t in common]
    scenes = np.array([r[0] for r in rows])
    labels = np.array([r[1] for r in rows])
    colours = np.array([r[3] for r in rows])
    nearest = np.empty(len(rows), dtype=int)
    for i in range(0, len(rows), 500):
        block = slice(i, i + 500)
        distance = ((colours[block, None] - colours[None]) ** 2).sum(axis=2)
        distance[scenes[block, None] == scenes[None]] = np.inf
        nearest[block] = distance.argmin(axis=1)
    accuracy = float((labels[nearest] == labels).mean())
    rng = np.random.default_rng(0)
    chance = np.mean([(labels[nearest] == shuffled).mean() for shuffled in (rng.permutation(labels) for _ in range(20))])
    assert len(common) > 50
    assert accuracy < chance + 0.03


def test_the_mean_colour_of_every_common_type_is_that_of_all(looks):
    """Means over scenes of a type's hues lie within sampling error of the pool's."""
    everything = np.array([c for _, _, _, c in looks])
    for category in ("Chair", "SideTable", "Vase", "Statue", "Pillow", "Box", "GarbageCan", "DeskLamp", "Sofa", "ArmChair"):
        own = np.array([c for _, t, _, c in looks if t == category])
        error = everything.std(axis=0) / np.sqrt(len(own))
        assert (np.abs(own.mean(axis=0) - everything.mean(axis=0)) < 4.5 * error + 0.03).all(), category
