"""The 120 iTHOR floor plans, from AI2-THOR's own metadata.

Source: the metadata in the pip package ``procthor``: one record for each object, with AI2-THOR's 42 keys. World frame: Unity's,
left-handed, y up, metres, degrees; yaw 0 is along +z, and 90 along +x.
"""

from __future__ import annotations

import importlib.util
import json
import mmap
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

KINDS = {
    "kitchens": ("kitchen", 1),
    "living_rooms": ("living_room", 201),
    "bedrooms": ("bedroom", 301),
    "bathrooms": ("bathroom", 401),
}
"""Group in the metadata -> kind of room, and number of its first floor plan. Each group has 30 floor plans."""
LATTICE_M = 0.25
"""Spacing of the lattice of recorded start positions."""
HEIGHT_DECIMALS = 9
"""Decimals of the start's height in metres: the last bits of LAPACK's solution depend on the alignment of its arrays."""


def rotation_matrix(euler_deg: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) of Unity's Euler angles (x, y, z), applied in the order z, x, y; it acts on columns: R = Ry Rx Rz."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(np.radians(euler_deg)), np.cos(np.radians(euler_deg))
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_y @ about_x @ about_z


def euler_degrees(rotation: np.ndarray) -> np.ndarray:
    """Inverse of `rotation_matrix`: Euler angles (x, y, z) in degrees, each in [0, 360)."""
    sin_x = -rotation[1, 2]
    if abs(sin_x) < 1 - 1e-9:
        x = np.arcsin(sin_x)
        y = np.arctan2(rotation[0, 2], rotation[2, 2])
        z = np.arctan2(rotation[1, 0], rotation[1, 1])
    else:
        x, z = np.copysign(np.pi / 2, sin_x), 0.0
        y = np.arctan2(-rotation[2, 0], rotation[0, 0])
    return np.degrees([x, y, z]) % 360.0


GAUSS_NEWTON_STEPS = 8


@dataclass(frozen=True)
class Box:
    """An oriented box: centre (3,) and half extents (3,) in metres, rotation (3, 3) from box to world axes."""

    centre: np.ndarray
    half: np.ndarray
    rotation: np.ndarray

    def corners(self) -> np.ndarray:
        """Return the eight corners, (8, 3), world frame, metres."""
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return self.centre + (signs * self.half) @ self.rotation.T

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner (3,) of the axis-aligned box around it, world frame, metres."""
        reach = np.abs(self.rotation) @ self.half
        return self.centre - reach, self.centre + reach


@dataclass(frozen=True)
class SimObject:
    """One object of an untouched floor plan."""

    object_id: str
    name: str
    type: str
    asset_id: str
    position: np.ndarray
    """(3,) metres; the pivot, not the centre of the box"""
    rotation: np.ndarray
    """(3, 3) from object to world axes"""
    box: Box
    """Oriented box. Fixed objects are recorded with an axis-aligned box only; its axes are then those of the nearest quarter
    turn, so that -z of the box is the back of the object in either case."""
    moveable: bool
    pickupable: bool
    mass: float
    parents: tuple[str, ...]
    record: Mapping[str, Any]
    """AI2-THOR's record of the object"""

    @property
    def dynamic(self) -> bool:
        """Whether the object can move: moveable or pickupable."""
        return self.moveable or self.pickupable


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """One untouched scene."""

    name: str
    kind: str
    """kitchen, living_room, bedroom, bathroom or house"""
    objects: tuple[SimObject, ...]
    start: np.ndarray
    """(3,) metres: where the agent stood when the metadata were recorded; free, and on the 0.25 m lattice"""
    floor_y: float
    """Height of the floor, metres"""
    house: Any = None
    """house.House for the plan of a house, which describes its own walls"""

    @property
    def floor(self) -> SimObject:
        """The first object of type Floor."""
        return next(o for o in self.objects if o.type == "Floor")

    def __getitem__(self, object_id: str) -> SimObject:
        """Return the object of an objectId. Raises KeyError if the plan has none."""
        return self._by_id[object_id]

    def __contains__(self, object_id: str) -> bool:
        """Whether the plan has an object of this objectId."""
        return object_id in self._by_id

    @property
    def _by_id(self) -> Mapping[str, SimObject]:
        cached = self.__dict__.get("_index")
        if cached is None:
            cached = MappingProxyType({o.object_id: o for o in self.objects})
            object.__setattr__(self, "_index", cached)
        return cached


def _vector(record: Mapping[str, float]) -> np.ndarray:
    return np.array([record["x"], record["y"], record["z"]], dtype=float)


def _box(record: Mapping[str, Any]) -> Box:
    aligned = record["axisAlignedBoundingBox"]
    oriented = record["objectOrientedBoundingBox"]
    euler = _vector(record["rotation"])
    if oriented is None:
        quarter = rotation_matrix(np.array([0.0, np.round(euler[1] / 90.0) * 90.0, 0.0]))
        return Box(_vector(aligned["center"]), np.abs(quarter.T @ _vector(aligned["size"])) / 2, quarter)
    rotation = rotation_matrix(euler)
    local = np.array(oriented["cornerPoints"], dtype=float) @ rotation
    low, high = local.min(axis=0), local.max(axis=0)
    return Box(rotation @ ((low + high) / 2), (high - low) / 2, rotation)


def _sim_object(record: Mapping[str, Any]) -> SimObject:
    return SimObject(
        object_id=record["objectId"],
        name=record["name"],
        type=record["objectType"],
        asset_id=record["assetId"],
        position=_vector(record["position"]),
        rotation=rotation_matrix(_vector(record["rotation"])),
        box=_box(record),
        moveable=record["moveable"],
        pickupable=record["pickupable"],
        mass=float(record["mass"]),
        parents=tuple(record["parentReceptacles"] or ()),
        record=MappingProxyType(record),
    )


def _start(objects: tuple[SimObject, ...]) -> np.ndarray:
    """Return the agent's start, rounded to the lattice in x and z.

    It is the point whose distances to all objects are the recorded ones.

    Differences of squared distances are linear in the point, so linear least squares solve for it. Gauss-Newton steps on the
    distances themselves make the solution exact.
    """
    points = np.array([o.position for o in objects])
    distances = np.array([o.record["distance"] for o in objects])
    centred = points - points.mean(axis=0)
    squares = (centred**2).sum(axis=1) - distances**2
    start = points.mean(axis=0) + np.linalg.lstsq(2 * centred, squares - squares.mean(), rcond=None)[0]
    for _ in range(GAUSS_NEWTON_STEPS):
        away = start - points
        lengths = np.linalg.norm(away, axis=1)
        start = start - np.linalg.lstsq(away / lengths[:, None], lengths - distances, rcond=None)[0]
    start[[0, 2]] = np.round(start[[0, 2]] / LATTICE_M) * LATTICE_M
    return start.round(HEIGHT_DECIMALS)


WINDOW = 1 << 20
"""Bytes of the database that are searched at once."""


@cache
def _database() -> mmap.mmap:
    found = importlib.util.find_spec("procthor")
    if found is None or not found.submodule_search_locations:
        raise FileNotFoundError("the pip package 'procthor' (floor-plan metadata) is not installed: pip install procthor")
    path = Path(found.submodule_search_locations[0]) / "databases" / "ai2thor-object-metadata.json"
    with path.open("rb") as file:
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def _find(what: bytes, start: int) -> int:
    """Offset of the next `what` in the file.

    Raises ValueError if the file has no more. The search of mmap itself compares byte by byte.
    """
    data = _database()
    while start < len(data):
        found = data[start : start + WINDOW].find(what)
        if found >= 0:
            return start + found
        start += WINDOW - len(what) + 1
    raise ValueError(f"the database of scenes holds no {what!r} after byte {start}")


@cache
def _place(group: str, index: int) -> int:
    """Offset of a scene of a group in the file."""
    if index < 0:
        return _find(b'\n    "%s": [' % group.encode(), 0)
    return _find(b"\n        [", _place(group, index - 1) + 1)


def _records(group: str, index: int) -> list[dict[str, Any]]:
    """Return the records of one scene.

    Parsing the whole file of 43 MB takes longer than building a scene, so the text of one scene is cut out by the indentation of
    its brackets: lists of lists of objects, four blanks a level.
    """
    data, begin, close = _database(), _place(group, index), b"\n        ]"
    records = json.loads(data[begin : _find(close, begin) + len(close)])
    if hasattr(mmap, "MADV_DONTNEED"):
        data.madvise(mmap.MADV_DONTNEED)  # pages that were read count as this process's memory until they are released
    return records


@cache
def names() -> tuple[str, ...]:
    """Return the 120 scene names, FloorPlan1 to FloorPlan430."""
    return tuple(f"FloorPlan{first + i}" for _, first in KINDS.values() for i in range(30))


@cache
def load(name: str) -> FloorPlan:
    """Return the floor plan `name` ("FloorPlan201"), cached for ever. Raises KeyError if no such scene exists."""
    return read(name)


def read(name: str) -> FloorPlan:
    """`load` without the cache. A floor plan takes a megabyte."""
    for group, (kind, first) in KINDS.items():
        if name in {f"FloorPlan{first + i}" for i in range(30)}:
            objects = tuple(_sim_object(r) for r in _records(group, int(name.removeprefix("FloorPlan")) - first))
            floor = next(o for o in objects if o.type == "Floor")
            return FloorPlan(name, kind, objects, _start(objects), float(floor.box.centre[1] + floor.box.half[1]))
    raise KeyError(name)
