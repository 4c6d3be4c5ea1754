"""A home from a seed, as ProcTHOR writes houses."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.homes.catalogue import SPLITS, database
from ovman.homes.check import Report, check
from ovman.homes.furnish import Furnisher, Thing
from ovman.homes.shell import HEIGHT_MM, Room, Shell, choose_paint, draw_shell, write_walls
from ovman.homes.stream import Stream
from ovman_engine.plan.house_json import read

ROOMS = (1, 2, 3)
ABUNDANT = 8
DRAWS = 20
CAMERA_MM = 950
"""Height of the agent in ProcTHOR's houses"""


def generate(seed: int | str, rooms: int, assets: str, abundant: int = ABUNDANT) -> dict[str, Any]:
    """Return a home as a house of ProcTHOR's schema. Equal arguments give equal bytes on every machine.

    rooms: 1, 2 or 3. assets: ProcTHOR's split whose assets it has, "train", "val" or "test". abundant: most categories with
    up to four loose instances that look different. metadata.spares: second places of things, by their ids.
    """
    if rooms not in ROOMS or assets not in SPLITS:
        raise ValueError(f"a home has 1, 2 or 3 rooms and assets of train, val or test; not {rooms!r} and {assets!r}")
    stream = Stream("ovman home", seed, rooms, assets, abundant)
    shell = draw_shell(stream, rooms, assets)
    furnisher = Furnisher(shell, stream, assets)
    furnisher.furnish(abundant)
    paint = choose_paint(stream, shell.rooms)
    return {
        "rooms": [_write_room(stream, room) for room in shell.rooms],
        "walls": write_walls(shell, paint, stream.choice(database("material-database.json")["Wall"])),
        "doors": shell.doors,
        "windows": shell.windows,
        "objects": [_write(thing, furnisher.things) for thing in furnisher.things if thing.parent is None],
        "proceduralParameters": _parameters(stream, shell),
        "metadata": {
            "agent": _agent(stream, furnisher),
            "roomSpecId": "-".join(room.kind for room in shell.rooms),
            "schema": "0.0.1",
            "warnings": {},
            "spares": {
                name: {"position": _vector(spare.x, 0, spare.z), "rotation": {"x": 0, "y": spare.yaw_deg, "z": 0}}
                for name, spare in furnisher.spares.items()
            },
        },
    }


def digest_house(house: Any) -> str:
    """Return the digits that the name of a house ends with."""
    return hashlib.sha256(json.dumps(house, sort_keys=True).encode()).hexdigest()[:8]


def read_house(path: Path) -> dict[str, Any]:
    """Return the house in a JSON file. Raises ValueError for one that the engine refuses, with the place in it and the reason."""
    house: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    read(house)
    return house


@dataclass(frozen=True)
class Home:
    """A home that has passed `check`. redraws: the faults of the draws before it."""

    name: str
    house: dict[str, Any]
    report: Report
    redraws: tuple[tuple[str, ...], ...]


def draw(seed: int | str, rooms: int, assets: str) -> Home:
    """Return the home of a seed, or of the first of its sub-seeds "seed.1", "seed.2", ... whose home passes `check`."""
    redraws: list[tuple[str, ...]] = []
    while len(redraws) < DRAWS:
        own_seed = f"{seed}.{len(redraws)}" if redraws else str(seed)
        house = generate(own_seed, rooms, assets)
        report = check(house)
        if report.ok:
            return Home(f"Home-{assets}-{rooms}-{own_seed}-{digest_house(house)}", house, report, tuple(redraws))
        redraws.append(report.faults)
    raise RuntimeError(f"seed {seed}: none of {DRAWS} homes of {rooms} rooms with {assets} assets is sound: {redraws[-1][0]}")


def _vector(x: float, y: float, z: float) -> dict[str, float]:
    """Return a vector of millimetres in metres."""
    return {"x": x / 1000, "y": y / 1000, "z": z / 1000}


def _write(thing: Thing, things: list[Thing]) -> dict[str, Any]:
    return {
        "id": thing.id,
        "assetId": thing.asset.id,
        "position": _vector(thing.x, thing.y + thing.asset.height // 2, thing.z),
        "rotation": {"x": 0, "y": thing.yaw_deg, "z": 0},
        "kinematic": not thing.asset.movable,
        "children": [_write(child, things) for child in things if child.parent == thing.id],
    }


def _write_room(stream: Stream, room: Room) -> dict[str, Any]:
    return {
        "id": f"room|{room.number}",
        "roomType": "LivingRoom" if room.kind == "Study" else room.kind,
        "floorMaterial": stream.choice(database("material-database.json")["Wood"]),
        "floorPolygon": [_vector(side.start[0], 0, side.start[1]) for side in room.sides],
        "ceilings": [],
        "children": [],
    }


def _agent(stream: Stream, furnisher: Furnisher) -> dict[str, Any]:
    x, z = furnisher.space.find_widest(furnisher.shell.rooms[0])
    yaw = stream.choice([0, 90, 180, 270])
    return {
        "position": _vector(x, CAMERA_MM, z),
        "rotation": {"x": 0, "y": yaw, "z": 0},
        "horizon": 30,
        "standing": True,
    }


def _parameters(stream: Stream, shell: Shell) -> dict[str, Any]:
    """Return the lights, sky and colliders that ProcTHOR's houses have."""
    shadow = {"type": "Soft", "strength": 1, "bias": 0, "normalBias": 0, "nearPlane": 0.2, "resolution": "FromQualitySettings"}
    white = {"r": 1.0, "g": 1.0, "b": 1.0}
    sun = {
        "id": "DirectionalLight",
        "type": "directional",
        "position": _vector(840, 185, -1090),
        "rotation": _vector(66000, 75000, 0),
    }
    lights = [{**sun, "intensity": 1, "indirectMultiplier": 1.0, "rgb": white, "shadow": shadow}]
    for room in shell.rooms:
        middle = _vector((room.box.x0 + room.box.x1) / 2, HEIGHT_MM - 200, (room.box.z0 + room.box.z1) / 2)
        lamp = {"id": f"light_{room.number}", "type": "point", "position": middle, "intensity": 0.45, "range": 15}
        lights.append({**lamp, "rgb": white, "shadow": {**shadow, "bias": 0.05}})
    return {
        "ceilingMaterial": "PureWhite",
        "ceilingColor": white,
        "floorColliderThickness": 1.0,
        "receptacleHeight": 0.7,
        "reflections": [],
        "skyboxId": stream.choice(sorted(database("skyboxes.json"))),
        "lights": lights,
    }
