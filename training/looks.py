"""Make ovman/homes/looks.json, the pairs of assets that look alike in pictures: `python -m training.looks [FOLDER]`.

Every asset that a robot could be asked for stands alone in the same room and light and is seen from its front and from its back,
at one distance for all of its category. Two assets look alike if neither their colours nor their outlines differ enough: COLOUR
and SHAPE were chosen by looking at the sheets in FOLDER, which show the assets of a category and, under each, those that look
like it.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw

from ovman.homes.catalogue import SPLITS, Asset, assets, categories
from ovman_engine.picture.camera import Renderer, View
from ovman_engine.plan.house_json import read
from ovman_engine.plan.houseplan import plan_of
from ovman_engine.world.world import World

TABLE = Path(__file__).parent.parent / "ovman" / "homes" / "looks.json"
PIXELS = 128
YAWS_DEG = (205.0, 25.0)
"""Directions of view: to the front and to the back of a thing at yaw 0, a little from the side"""
BANDS = 3
"""The colour is compared in as many bands of equal height, from top to bottom."""
COLOUR = 14.0
"""Distance in CIELAB (mean over bands and views) from which two assets look different"""
SHAPE = 0.5
"""Share of their common outline that two assets do not share (1 - IoU, mean over views) from which they look different"""
BOTH = 1.25
"""Two smaller differences add up: colour / COLOUR + shape / SHAPE from which two assets look different"""


@dataclass(frozen=True)
class Portrait:
    """How one asset looks. colours (views, BANDS, 3): CIELAB; masks (views, PIXELS, PIXELS); picture: its front."""

    asset: Asset
    colours: np.ndarray
    masks: np.ndarray
    picture: np.ndarray


def take_portrait(asset: Asset, distance_m: float) -> Portrait:
    """Return the portrait of an asset from a distance to its middle."""
    floor = [{"x": x, "y": 0, "z": z} for x, z in ((-6, -6), (-6, 6), (6, 6), (6, -6))]
    walls = [
        {"id": f"wall|2|{k}", "roomId": "room|2", "material": "PureWhite", "color": {"r": 0.7, "g": 0.7, "b": 0.7},
         "polygon": [{**a, "y": y} if end == 0 else {**b, "y": y} for y in (0, 3) for end in (0, 1)]}
        for k, (a, b) in enumerate(zip(floor, floor[1:] + floor[:1], strict=True))
    ]  # fmt: skip
    thing = {"id": "it", "assetId": asset.id, "position": {"x": 0, "y": asset.height / 2000, "z": 0}}
    house = {"rooms": [{"id": "room|2", "roomType": "LivingRoom", "floorPolygon": floor}], "walls": walls, "objects": [thing]}
    renderer = Renderer(World(plan_of(read(house))))
    colours, masks, pictures = [], [], []
    for yaw in YAWS_DEG:
        back = np.array([np.sin(np.radians(yaw)), 0.0, np.cos(np.radians(yaw))]) * distance_m
        at = np.array([0.0, asset.height / 2000 + 0.35 * distance_m, 0.0]) - back
        frame = renderer.frame(View(at, yaw, 19.3, 50.0, PIXELS, PIXELS), ids=True)
        assert frame.rgb is not None and frame.ids is not None  # both were asked for
        mask = np.equal(frame.ids, renderer.names.index("it"))
        rows, lab = np.flatnonzero(mask.any(axis=1)), cv2.cvtColor(frame.rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
        bands = np.array_split(rows, BANDS)
        colours.append([lab[band][mask[band]].mean(axis=0) if len(band) else lab[mask].mean(axis=0) for band in bands])
        masks.append(mask)
        pictures.append(frame.rgb)
    return Portrait(asset, np.array(colours), np.array(masks), pictures[0])


def measure_difference(first: Portrait, second: Portrait) -> tuple[float, float]:
    """Return the distance of two assets in colour and in shape."""
    colour = np.linalg.norm(first.colours - second.colours, axis=-1).mean()
    both, either = (first.masks & second.masks).sum(axis=(1, 2)), (first.masks | second.masks).sum(axis=(1, 2))
    return float(colour), float(1 - (both / np.maximum(either, 1)).mean())


def look_alike(first: Portrait, second: Portrait) -> bool:
    """Return whether a robot could take one asset for the other."""
    colour, shape = measure_difference(first, second)
    return colour < COLOUR and shape < SHAPE and colour / COLOUR + shape / SHAPE < BOTH


def portray(category: str) -> list[tuple[str, list[Portrait]]]:
    """Return the portraits of the movable assets of a category, by split."""
    pools = [(split, [a for a in assets(category, split) if a.movable]) for split in SPLITS]
    size = max((max(a.width, a.height, a.depth) for _, pool in pools for a in pool), default=0)
    return [(split, [take_portrait(a, 1.3 * size / 1000 + 0.15) for a in pool]) for split, pool in pools]


def draw_sheet(pools: list[tuple[str, list[Portrait]]], alike: set[tuple[str, str]], columns: int = 12) -> Image.Image:
    """Return the portraits of a category: each with a number, and the numbers of those that look like it."""
    portraits = [(split, portrait) for split, pool in pools for portrait in pool]
    sheet = Image.new("RGB", (columns * PIXELS, -(-len(portraits) // columns) * (PIXELS + 14)), "white")
    draw = ImageDraw.Draw(sheet)
    for k, (split, one) in enumerate(portraits):
        x, y = k % columns * PIXELS, k // columns * (PIXELS + 14)
        sheet.paste(Image.fromarray(one.picture), (x, y))
        same = [j for j, (_, o) in enumerate(portraits) if {(o.asset.id, one.asset.id), (one.asset.id, o.asset.id)} & alike]
        draw.text((x + 2, y + PIXELS), f"{split[:2]} {k} = {' '.join(map(str, same))}", fill="black")
    return sheet


def main() -> None:
    """Write the table, and the sheet if a file is named."""
    table: dict[str, list[list[str]]] = {}
    sheets = []
    for category in categories():
        pools = portray(category)
        pairs = [pair for _, pool in pools for pair in combinations(pool, 2)]
        table[category] = [[a.asset.id, b.asset.id] for a, b in pairs if look_alike(a, b)]
        print(f"{category}: {len(table[category])} of {len(pairs)} pairs look alike", flush=True)
        if pairs:
            sheets.append((category, draw_sheet(pools, {(a, b) for a, b in table[category]})))
    TABLE.write_text(json.dumps({k: v for k, v in table.items() if v}, indent=None, separators=(",", ":")) + "\n")
    for category, sheet in sheets if len(sys.argv) > 1 else ():
        path = Path(sys.argv[1])
        path.mkdir(parents=True, exist_ok=True)
        sheet.save(path / f"{category}.png")


if __name__ == "__main__":
    main()
