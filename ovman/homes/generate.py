"""A home from a seed, as ProcTHOR writes houses."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from ovman.homes.catalogue import SPLITS, database
from ovman.homes.check import Report, check
from ovman.homes.furnish import Furnisher, Thing
from ovman.homes.shell import HEIGHT_MM, Room, Shell, choose_paint, draw_shell, write_walls
from ovman.homes.stream import Stream

ROOMS = (1, 2, 3)
ABUNDANT = 6
ATTEMPTS = 20
NAME = re.compile(r"Home-(train|val|test)-([123])-([0-9]+(?:\.[0-9]+)?)(?:-([0-9]+))?")
CAMERA_MM = 950
"""Height of the agent in ProcTHOR's houses"""


def generate(seed: int | str, rooms: int, assets: str, abundant: int = ABUNDANT, attempt: int = 0) -> dict[str, Any]:
    """Return a home as a house of ProcTHOR's schema. Equal arguments give equal bytes on every machine.

    rooms: 1, 2 or 3. assets: ProcTHOR's split whose assets it has, "train", "val" or "test". abundant: number of categories
    with two to four loose instances that look different. attempt: another home of the same seed, for one that fails `check`.
    """
    if rooms not in ROOMS or assets not in SPLITS:
        raise ValueError(f"a home has 1, 2 or 3 rooms and assets of train, val or test; not {rooms!r} and {assets!r}")
    stream = Stream("ovman home", seed, rooms, assets, abundant, attempt)
    shell = draw_shell(stream, rooms, assets)
    furnisher = Furnisher(shell, stream, assets)
    furnisher.furnish(abundant)
    paint = choose_paint(stream, shell.rooms)
    return {
        "rooms": [_write_room(stream, room) for room in shell.rooms],
        "walls": write_walls(shell, paint),
        "doors": shell.doors,
        "windows": shell.windows,
        "objects": [_write(thing, furnisher.things) for thing in furnisher.things if thing.parent is None],
        "proceduralParameters": _parameters(stream, shell),
        "metadata": {
            "agent": _agent(stream, furnisher),
            "roomSpecId": "-".join(room.kind for room in shell.rooms),
            "schema": "0.0.1",
            "warnings": {},
        },
    }


@dataclass(frozen=True)
class Home:
    """A home that has passed `check`. redraws: the faults of the attempts before it."""

    name: str
    house: dict[str, Any]
    report: Report
    redraws: tuple[tuple[str, ...], ...]


def draw(seed: int | str, rooms: int, assets: str) -> Home:
    """Return the first home of a seed that passes `check`."""
    redraws: list[tuple[str, ...]] = []
    while len(redraws) < ATTEMPTS:
        house = generate(seed, rooms, assets, attempt=len(redraws))
        report = check(house)
        if report.ok:
            suffix = f"-{len(redraws)}" if redraws else ""
            return Home(f"Home-{assets}-{rooms}-{seed}{suffix}", house, report, tuple(redraws))
        redraws.append(report.faults)
    raise RuntimeError(f"seed {seed}: none of {ATTEMPTS} homes of {rooms} rooms with {assets} assets is sound: {redraws[-1][0]}")


def named(name: str) -> dict[str, Any]:
    """Return the home of a name that `draw` gave. Raises ValueError for another name."""
    found = NAME.fullmatch(name)
    if found is None:
        raise ValueError(f"{name} is no home; homes have names such as Home-test-2-7.3: assets, rooms, seed and number")
    assets, rooms, seed, attempt = found.groups()
    return generate(seed, int(rooms), assets, attempt=int(attempt or 0))


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
    white = {"r": 1.0, "g": 1.0, "b": 1.0}
    sun = {
        "id": "DirectionalLight",
        "type": "directional",
        "position": {"x": 0.84, "y": 0.1855, "z": -1.09},
        "rotation": {"x": 66, "y": 75, "z": 0},
        "intensity": 1,
        "indirectMultiplier": 1.0,
        "rgb": white,
        "shadow": _shadow(0, 0),
    }
    lamps = []
    for room in shell.rooms:
        x, z = (room.box.x0 + room.box.x1) / 2, (room.box.z0 + room.box.z1) / 2
        lamps.append(
            {
                "id": f"light_{room.number}",
                "type": "point",
                "position": _vector(x, HEIGHT_MM - 200, z),
                "intensity": 0.45,
                "range": 15,
                "rgb": white,
                "shadow": _shadow(0.05, 0.4),
            }
        )
    return {
        "ceilingMaterial": "PureWhite",
        "ceilingColor": white,
        "floorColliderThickness": 1.0,
        "receptacleHeight": 0.7,
        "reflections": [],
        "skyboxId": stream.choice(sorted(database("skyboxes.json"))),
        "lights": [sun, *lamps],
    }


def _shadow(bias: float, normal_bias: float) -> dict[str, Any]:
    return {
        "type": "Soft",
        "strength": 1,
        "bias": bias,
        "normalBias": normal_bias,
        "nearPlane": 0.2,
        "resolution": "FromQualitySettings",
    }
