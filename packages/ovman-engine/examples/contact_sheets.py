"""Draws what the engine's objects and rooms look like: docs/types.png and docs/rooms.png.

python examples/contact_sheets.py [FOLDER]
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ovman_engine.picture.camera import Renderer, View
from ovman_engine.plan import floorplan
from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.shapes import surroundings
from ovman_engine.world.world import World

CELL_PX, COLUMNS = 140, 14
FREQUENT, ASSETS = 24, 3
"""So many of the most frequent types are shown with so many assets, the others with one."""
ROOM_PX, ROOMS_OF_A_KIND = (392, 294), 3
COLOURS = 256
FOV_DEG, ROOM_M = 40.0, 2.4
"""Large things are seen from so near, at a wider angle: farther away a wall would be in between."""
PROBE_PX = 40
LEAST_SHARE = 0.03
"""What covers less of its cell is hidden."""
STRIDE = 37
"""Plans are gone through in steps of this, coprime to their number: neighbours in the list are variants of one another."""


def best_view(renderer: Renderer, object_id: str, quarter: int) -> tuple[View, float]:
    """The view of an object where it is that shows most of it, whole, rather its front, `quarter` quarter turns from the +z of
    its box, than its back; the share of the picture that it covers.
    """
    box = renderer.world.box(object_id)
    front = box.rotation @ surroundings.direction(quarter)
    number = renderer.names.index(object_id)
    radius = 1.08 * float(np.linalg.norm(box.half))
    away = float(np.clip(radius / np.sin(np.radians(FOV_DEG / 2)), 0.2, max(1.4 * radius, ROOM_M)))
    fov = float(max(2 * np.degrees(np.arcsin(radius / away)), 20.0))
    best, most = None, (-np.inf, 0.0)
    for horizon in (25.0, 8.0, 50.0):
        for yaw in np.arange(0.0, 360.0, 30.0) + 15.0:
            forward = View(np.zeros(3), float(yaw), horizon).axes()[2]
            view = View(box.centre - away * forward, float(yaw), horizon, fov, PROBE_PX, PROBE_PX, near_m=0.02)
            seen = renderer.frame(view, rgb=False, ids=True).ids == number
            cut = int(seen[0].any()) + int(seen[-1].any()) + int(seen[:, 0].any()) + int(seen[:, -1].any())
            score = seen.mean() * 0.6**cut * (1.0 - 0.35 * float(front @ forward))
            if score > most[0]:
                best, most = view, (score, float(seen.mean()))
    return best, most[1]


def portrait(plan: FloorPlan, renderer: Renderer, obj: SimObject, size: int) -> np.ndarray:
    """(size, size, 3) picture of `obj` where it stands; what lies hidden is shown where the agent starts."""
    quarter = surroundings.front(obj, plan)
    view, share = best_view(renderer, obj.object_id, quarter)
    if share < LEAST_SHARE:
        world = World(plan)
        if obj.dynamic:
            world.teleport(obj.object_id, plan.start + [0.0, -0.3, 0.0], force=True)
        else:
            world.remove(*(o.object_id for o in plan.objects if o is not obj and o.type != "Floor"))
        renderer = Renderer(world)
        view, _ = best_view(renderer, obj.object_id, quarter)
    fine = replace(view, width=2 * size, height=2 * size)
    return np.asarray(Image.fromarray(renderer.frame(fine).rgb).resize((size, size), Image.LANCZOS))


def portraits(plans: Sequence[FloorPlan]) -> dict[str, list[np.ndarray]]:
    """Pictures of every type but the floor: of the frequent ones several assets, of the others one."""
    counts = Counter(o.type for plan in plans for o in plan.objects)
    wanted = {t: ASSETS if k < FREQUENT else 1 for k, (t, _) in enumerate(counts.most_common()) if t != "Floor"}
    found: dict[str, dict[str, np.ndarray]] = {t: {} for t in sorted(wanted)}
    for plan in plans:
        renderer = Renderer(World(plan))
        for o in plan.objects:
            looks, asset = found.get(o.type), o.asset_id or plan.name
            if looks is not None and asset not in looks and len(looks) < wanted[o.type]:
                looks[asset] = portrait(plan, renderer, o, CELL_PX)
    return {t: list(looks.values()) for t, looks in found.items()}


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
    """Cells for every type but the floor."""
    names = floorplan.names()
    shown = portraits([floorplan.load(names[i * STRIDE % len(names)]) for i in range(len(names))])
    return tiled([labelled(picture, name) for name, pictures in shown.items() for picture in pictures], COLUMNS)


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
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[1] / "docs")
    folder.mkdir(parents=True, exist_ok=True)
    for name, sheet in (("types", types()), ("rooms", tiled(list(rooms()), 4))):
        sheet.quantize(COLOURS, dither=Image.Dither.NONE).save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
