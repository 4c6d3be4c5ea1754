"""`ovman homes`: homes as JSON files, with a table of what is in them and a sheet of pictures."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ovman.homes.catalogue import Asset, assets, categories
from ovman.homes.generate import ROOMS, Home, draw
from ovman.processes import Step

COLUMNS = ("name", "kinds", "area_m2", "cells", "things", "movable", "large", "on_tops", "abundant", "redraws", "why")
FILES = ("index.csv", "homes.png")
SIDE_PX, LABEL_PX, GAP_PX = 300, 26, 4
VIEWS = 4
HORIZON_DEG = 12.0
"""The camera looks down by this much"""
PAPER, INK = (250, 249, 246), (40, 40, 40)


class HomesError(ValueError):
    """A wrong option; one line with the option and the remedy."""

    says_all = True


def run(seed: int, count: int, rooms: str, split: str, out: Path, pictures: bool, say: Callable[[str], None]) -> list[Home]:
    """Draw homes 0 to `count` - 1 of a seed; write a file for each, index.csv and homes.png.

    rooms: numbers of rooms in turn, such as "1,2". say: is told of each home. HomesError for an option without meaning, or a
    folder that holds something else.
    """
    if seed < 0 or count < 1:
        raise HomesError(f"--seed is {seed} and --count {count}; write a seed of at least 0 and at least 1 home")
    numbers = rooms.split(",")
    if not {*numbers} <= {*map(str, ROOMS)}:
        raise HomesError(f"--rooms is {rooms}; write numbers from 1 to 3, such as 1,2")
    if out.exists() and (not out.is_dir() or any(p.name not in FILES and p.suffix != ".json" for p in out.iterdir())):
        raise HomesError(f"--out: {out} holds other files; name a new folder")
    out.mkdir(parents=True, exist_ok=True)
    homes: list[Home] = []
    with (out / "index.csv").open("w", newline="") as file:
        index = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        index.writeheader()
        for k in range(count):
            homes.append(draw(f"{seed}.{k}", int(numbers[k % len(numbers)]), split))
            row = describe(homes[-1], split)
            index.writerow(row)
            (out / f"{homes[-1].name}.json").write_text(json.dumps(homes[-1].house, sort_keys=True) + "\n", encoding="utf-8")
            say(Step(k + 1, count, f"{row['name']}: {row['kinds']}, {row['area_m2']} m2, {row['movable']} movable things"))
    if pictures:
        draw_sheet(homes, say).save(out / "homes.png")
    return homes


def describe(home: Home, split: str) -> dict[str, Any]:
    """Return the row of a home in the index. abundant: categories with several loose things, and how many."""
    things = list(list_things(home.house, split))
    loose = Counter(asset.category for _, asset, _ in things if asset.loose)
    return {
        "name": home.name,
        "kinds": home.house["metadata"]["roomSpecId"],
        "area_m2": " + ".join(f"{area:.1f}" for area in home.report.areas_m2.values()),
        "cells": sum(home.report.cells.values()),
        "things": len(things),
        "movable": sum(asset.movable for _, asset, _ in things),
        "large": sum(asset.movable and asset.large for _, asset, _ in things),
        "on_tops": sum(on_top for _, _, on_top in things),
        "abundant": " ".join(f"{category}:{n}" for category, n in sorted(loose.items()) if n > 1),
        "redraws": len(home.redraws),
        "why": "; ".join(faults[0] for faults in home.redraws),
    }


def list_things(house: Mapping[str, Any], split: str) -> Iterator[tuple[int, Asset, bool]]:
    """Yield the room, the asset, and whether it stands on another thing, of each object of a home."""
    by_id = {a.id: a for category in categories() for a in assets(category, split)}

    def walk(objects: Sequence[Mapping[str, Any]], on_top: bool) -> Iterator[tuple[int, Asset, bool]]:
        for thing in objects:
            yield int(thing["id"].split("|")[1]), by_id[thing["assetId"]], on_top
            yield from walk(thing["children"], True)

    return walk(house["objects"], False)


def draw_sheet(homes: Sequence[Home], say: Callable[[str], None]) -> Image.Image:
    """Return a sheet with a row for each home: what a robot sees at four places, and the home from above."""
    from ai2thor.controller import Controller

    from ovman_engine import executable

    height = LABEL_PX + SIDE_PX + GAP_PX
    sheet = Image.new("RGB", ((VIEWS + 1) * (SIDE_PX + GAP_PX) + GAP_PX, len(homes) * height + GAP_PX), PAPER)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(16)
    controller = Controller(local_executable_path=executable(), scene=homes[0].house, width=SIDE_PX, height=SIDE_PX)
    try:
        for row, home in enumerate(homes):
            controller.reset(home.house)
            top = row * height + GAP_PX
            areas = " + ".join(f"{area:.0f}" for area in home.report.areas_m2.values())
            kinds = home.house["metadata"]["roomSpecId"].replace("-", ", ")
            pen.text((GAP_PX + 2, top + 2), f"{home.name}    {kinds}, {areas} m2", INK, font)
            for column, frame in enumerate((*_look_around(controller, home), _look_down(controller))):
                sheet.paste(Image.fromarray(frame), (GAP_PX + column * (SIDE_PX + GAP_PX), top + LABEL_PX))
            say(Step(row + 1, len(homes), f"{home.name}: drawn"))
    finally:
        controller.stop()
    return sheet


def _look_around(controller: Any, home: Home) -> Iterator[np.ndarray]:
    """Yield pictures towards the middle of the rooms from their corners, the rooms in turn."""
    positions = controller.step("GetReachablePositions").metadata["actionReturn"]
    points = np.array([(p["x"], p["z"]) for p in positions])
    rooms = [np.array([(p["x"], p["z"]) for p in room["floorPolygon"]]) for room in home.house["rooms"]]
    for view in range(VIEWS):
        corners = rooms[view % len(rooms)]
        low, high = corners.min(axis=0), corners.max(axis=0)
        turn = view // len(rooms)
        corner = np.where([turn in (1, 2), turn in (1, 3)], high, low)
        inside = points[((points >= low) & (points <= high)).all(axis=1)]
        x, z = inside[np.hypot(*(inside - corner).T).argmin()]
        towards = (low + high) / 2 - [x, z]
        yaw = math.degrees(math.atan2(*towards))
        place = {"position": {"x": x, "y": positions[0]["y"], "z": z}, "rotation": {"x": 0, "y": yaw, "z": 0}}
        yield controller.step("TeleportFull", **place, horizon=HORIZON_DEG, standing=True, forceAction=True).frame


def _look_down(controller: Any) -> np.ndarray:
    frame: np.ndarray = controller.step("ToggleMapView").frame
    controller.step("ToggleMapView")
    return frame
