"""Appearance: glass is seen through, the sun shines through windows, sinks are hollow, sheets show every type."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ovman_engine.paint import materials
from ovman_engine.picture import scene_mesh, sunshine
from ovman_engine.picture.camera import Renderer, View
from ovman_engine.plan import floorplan
from ovman_engine.shapes import Part
from ovman_engine.world.world import World

LOW, HIGH = np.array([-2.0, 0.0, -3.0]), np.array([4.0, 2.5, 5.0])
SOFT_M = 0.3
"""Blur of the edge of a sunlit patch on the coarse grid."""
PAINT = {
    "main": materials.Material(np.array([0.5, 0.4, 0.3])),
    "glass": materials.Material(np.array([0.6, 0.7, 0.7]), gloss=1.0, clear=True),
    "red": materials.Material(np.array([0.9, 0.02, 0.02]), gloss=0.0),
}


class Hall:
    """A room with slabs (slot, low, high) in world coordinates."""

    def __init__(self, *slabs) -> None:
        self.plan = floorplan.FloorPlan("Hall", "none", (), np.zeros(3), 0.0)
        self.room, self.bodies, self.version = self, {}, 0
        self._slabs = (("main", LOW, HIGH), *slabs)

    def parts(self):
        for k, (slot, low, high) in enumerate(self._slabs):
            low, high = np.array(low, float), np.array(high, float)
            yield f"{slot} {k}", (Part("box", (low + high) / 2, high - low, slot=slot),), PAINT


@pytest.mark.parametrize("panes", [1, 2])
def test_glass_is_seen_through_but_is_what_stands_there(panes):
    """Red shows through one pane and through two; the ids and depths are the first pane's."""
    glass = [("glass", (-1, 0, 1 + 0.3 * k), (1, 2.4, 1.01 + 0.3 * k)) for k in range(panes)]
    red = ("red", (-1, 0, 2), (1, 2.4, 2.1))
    renderer = Renderer(Hall(*glass, red))
    view = View(np.array([0.0, 1.2, 0.0]), 0, fov_deg=40, width=20, height=20)
    frame = renderer.frame(view, depth=True, ids=True)
    assert renderer.names[frame.ids[10, 10]] == "glass 1"
    assert frame.depth[10, 10] == pytest.approx(1.0, abs=1e-3)
    seen = frame.rgb[10, 10].astype(int)
    assert seen[0] > seen[1] + 50
    plain = Renderer(Hall(*glass)).frame(view).rgb[10, 10].astype(int)
    assert plain[0] < plain[1] + 40


def sunny() -> list[World]:
    """Worlds that the sun shines into."""
    found = []
    for name in floorplan.names()[4::9]:
        world = World(floorplan.load(name))
        meshes = scene_mesh.of_plan(world.plan, world.room)
        low, high = meshes.untouched.vertices.min(axis=0), meshes.untouched.vertices.max(axis=0)
        if sunshine.of_plan(world.plan, low, high, set(world.bodies), 1.0) is not None:
            found.append(world)
    return found


@pytest.mark.soak
def test_the_sun_only_adds_light_and_only_where_it_falls_through_a_window():
    patches, inside = 0, []
    for world in sunny()[:6]:
        renderer = Renderer(world)
        low, high = world.room.outline[:2], world.room.outline[2:]
        x, z = (low[0] + high[0]) / 2, (low[1] + high[1]) / 2
        view = View(np.array([x, world.room.ceiling_y - 0.1, z]), 0, 90, width=120, height=120, fov_deg=110)
        lit = renderer.frame(view, depth=True)
        sun = renderer._rig.sun
        assert np.linalg.norm(sun.way) == pytest.approx(1, abs=1e-5) and sun.way[1] > 0.3
        renderer._rig = replace(renderer._rig, sun=None)
        dull = renderer.frame(view)
        gain = lit.rgb.astype(int).sum(axis=2) - dull.rgb.astype(int).sum(axis=2)
        assert (gain < -9).mean() < 0.01, "but for highlights that move and edges that are sampled otherwise"
        rows, columns = np.nonzero(gain > 60)
        patches += len(rows) > 0
        tall = np.tan(np.radians(55))
        right, up, forward = view.axes()
        for r, c in zip(rows[::7], columns[::7], strict=True):
            ray = forward + ((c + 0.5) / 60 - 1) * tall * right + (1 - (r + 0.5) / 60) * tall * up
            point = view.position + lit.depth[r, c] * ray
            hits = []
            for axis, plane, first, last, bottom, top in sun.panes:
                axis = int(axis)
                at = point + sun.way * (plane - point[axis]) / sun.way[axis]
                hits.append(first - SOFT_M < at[2 - axis] < last + SOFT_M and bottom - SOFT_M < at[1] < top + SOFT_M)
            inside.append(any(hits))
    assert patches >= 2 and np.mean(inside) > 0.97
