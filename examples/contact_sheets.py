"""Draws what the engine's objects and rooms look like: docs/engine/types.png and docs/engine/rooms.png.

python examples/contact_sheets.py [FOLDER]
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ovman.engine import floorplan
from ovman.engine.camera import Renderer, View
from ovman.engine.floorplan import FloorPlan, SimObject
from ovman.engine.world import World

CELL_PX, COLUMNS = 150, 15
FREQUENT, ASSETS = 24, 3
"""So many of the most frequent types are shown with so many assets, the others with one."""
ROOM_PX, ROOMS_OF_A_KIND = (400, 300), 3
COLOURS = 96
FOV_DEG = 40.0
PROBE_PX = 40
STRIDE = 37
"""Plans are gone through in steps of this, coprime to their number: neighbours in the list are variants of one another."""


def portrait(renderer: Renderer, obj: SimObject, size: int) -> np.ndarray:
    """(size, size, 3) picture of `obj` where it stands, from the side from which most of it is seen."""
    number = renderer.names.index(obj.object_id)
    radius = float(np.linalg.norm(obj.box.half))
    away = max(1.05 * radius / np.sin(np.radians(FOV_DEG / 2)), 0.2)
    best, seen = None, -1
    for horizon in (25.0, 8.0, 50.0):
        for yaw in np.arange(0.0, 360.0, 30.0) + 15.0:
            view = View(np.zeros(3), float(yaw), horizon, FOV_DEG, PROBE_PX, PROBE_PX, near_m=0.02)
            view = View(obj.box.centre - away * view.axes()[2], float(yaw), horizon, FOV_DEG, PROBE_PX, PROBE_PX, near_m=0.02)
            count = int((renderer.frame(view, rgb=False, ids=True).ids == number).sum())
            if count > 1.15 * seen:
                best, seen = view, count
    fine = View(best.position, best.yaw_deg, best.horizon_deg, FOV_DEG, 2 * size, 2 * size, near_m=0.02)
    return np.asarray(Image.fromarray(renderer.frame(fine).rgb).resize((size, size), Image.LANCZOS))


def shown(plans: Sequence[FloorPlan]) -> list[tuple[FloorPlan, SimObject]]:
    """What the sheet of types shows: for every type its first assets, the frequent types with several."""
    counts = Counter(o.type for plan in plans for o in plan.objects)
    frequent = {t for t, _ in counts.most_common(FREQUENT)}
    found: dict[str, dict[str, tuple[FloorPlan, SimObject]]] = {t: {} for t in sorted(counts)}
    for plan in plans:
        for o in plan.objects:
            looks = found[o.type]
            if o.type != "Floor" and len(looks) < (ASSETS if o.type in frequent else 1):
                looks.setdefault(o.asset_id or plan.name, (plan, o))
    return [shot for looks in found.values() for shot in looks.values()]


def labelled(picture: np.ndarray, text: str) -> Image.Image:
    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, 6 + draw.textlength(text), 12), fill=(20, 20, 20))
    draw.text((3, 1), text, fill=(255, 255, 255))
    return image


def tiled(tiles: Sequence[Image.Image], columns: int) -> Image.Image:
    wide, high = tiles[0].size
    sheet = Image.new("RGB", (columns * wide, -(-len(tiles) // columns) * high))
    for k, tile in enumerate(tiles):
        sheet.paste(tile, (k % columns * wide, k // columns * high))
    return sheet


def types() -> Image.Image:
    """One cell for every type but the floor."""
    names = floorplan.names()
    plans = [floorplan.load(names[i * STRIDE % len(names)]) for i in range(len(names))]
    shots = shown(plans)
    pictures: dict[int, Image.Image] = {}
    for plan in plans:
        wanted = [k for k, (p, _) in enumerate(shots) if p is plan]
        if wanted:
            renderer = Renderer(World(plan))
            for k in wanted:
                pictures[k] = labelled(portrait(renderer, shots[k][1], CELL_PX), shots[k][1].type)
    return tiled([pictures[k] for k in range(len(shots))], COLUMNS)


def widest(renderer: Renderer, world: World) -> np.ndarray:
    """The view at eye height that shows most objects."""
    cells = world.reachable()
    best, most = None, -1
    for x, y, z in cells[:: max(1, len(cells) // 24)]:
        for yaw in range(0, 360, 45):
            view = View(np.array([x, y + 0.675, z]), float(yaw), 15.0, 80.0, 64, 48)
            frame = renderer.frame(view, rgb=False, ids=True, depth=True)
            many = len(np.unique(frame.ids)) * float(np.minimum(frame.depth, 4.0).mean())
            if many > most:
                best, most = view, many
    wide, high = ROOM_PX
    fine = View(best.position, best.yaw_deg, best.horizon_deg, best.fov_deg, 2 * wide, 2 * high)
    return np.asarray(Image.fromarray(renderer.frame(fine).rgb).resize(ROOM_PX, Image.LANCZOS))


def rooms() -> Iterator[Image.Image]:
    """Three rooms of each kind, one kind after the other in a row."""
    kinds = [[n for n in floorplan.names() if floorplan.load(n).kind == kind] for kind, _ in floorplan.KINDS.values()]
    for row in list(zip_longest(*kinds))[4::10][:ROOMS_OF_A_KIND]:
        for name in row:
            world = World(floorplan.load(name))
            yield labelled(widest(Renderer(world), world), name)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / "docs" / "engine")
    folder.mkdir(parents=True, exist_ok=True)
    for name, sheet in (("types", types()), ("rooms", tiled(list(rooms()), 4))):
        sheet.quantize(COLOURS, dither=Image.Dither.NONE).save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
