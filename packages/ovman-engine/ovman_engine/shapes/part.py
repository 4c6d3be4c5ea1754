"""Parts: the primitives that every object is made of, and short ways to write them.

A part is drawn (`tessellation.mesh`) and collided with (`collision.collision`). It lives in the frame of an oriented box: origin
at the centre of the box, metres, y up, -z the back. Kinds, and what `ratio` and `points` mean for each:

======== ============================================================ =========================== =====================
kind     form, within `size` along the part's own axes                ratio                       points (metres)
======== ============================================================ =========================== =====================
box      cuboid, edges cut by `bevel` metres
cylinder axis y, elliptic where size x and z differ
frustum  axis y                                                       top width / bottom width
ellipsoid
cushion  superellipsoid: a box with soft faces                        exponent, 0 box, 1 ellipsoid
capsule  axis y, round ends
torus    ring about y                                                 tube width / outer radius
prism    convex outline in x, y, counter-clockwise, extruded along z                              (N, 2) x, y
lathe    profile revolved about y; runs upwards on the outside                                    (N, 2) radius, y
tube     round rod along a path                                                                   (N, 3) path
leaf     blade from the origin along +y, curling towards +z
======== ============================================================ =========================== =====================
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

KINDS = ("box", "cylinder", "frustum", "ellipsoid", "cushion", "capsule", "torus", "prism", "lathe", "tube", "leaf")


def _vector(values: Any) -> np.ndarray:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


IDENTITY = _vector(np.eye(3))
_PLACE = {"centre", "rotation"}


@dataclass(frozen=True, eq=False)
class Part:
    """One primitive. See the module for the kinds. Raises ValueError for an unknown kind or a size that is not positive."""

    kind: str
    centre: np.ndarray
    """(3,) metres"""
    size: np.ndarray
    """(3,) full extents along the part's own axes, metres"""
    rotation: np.ndarray = field(default_factory=lambda: IDENTITY)
    """(3, 3) from the part's axes to those of the box"""
    slot: str = "main"
    """Slot of the object's palette"""
    solid: bool = True
    """Whether it takes part in collisions"""
    drawn: bool = True
    """Whether it is drawn. A solid part that is not drawn stands in for a group of drawn parts that are not solid"""
    bevel: float = 0.0
    """box: metres cut off every edge"""
    ratio: float = 1.0
    crown: float = 0.0
    """cushion: exponent of its height, 0 for `ratio`; above 1 it is pinched like a pillow"""
    points: np.ndarray | None = None
    segments: int = 0
    """Facets around the axis; 0 chooses them by size."""

    if TYPE_CHECKING:  # arrays may be given as any sequence: __post_init__ converts them

        def __init__(
            self,
            kind: str,
            centre: ArrayLike,
            size: ArrayLike,
            rotation: ArrayLike = ...,
            slot: str = ...,
            solid: bool = ...,
            drawn: bool = ...,
            bevel: float = ...,
            ratio: float = ...,
            crown: float = ...,
            points: ArrayLike | None = ...,
            segments: int = ...,
        ) -> None:
            """Set the fields of the class."""

    def __post_init__(self) -> None:
        """Check kind and size, and converts sequences to arrays."""
        if self.kind not in KINDS:
            raise ValueError(f"unknown kind of part {self.kind!r}; known: {', '.join(KINDS)}")
        for name in ("centre", "size", "rotation"):
            if (value := getattr(self, name)) is not IDENTITY:
                object.__setattr__(self, name, _vector(value))
        if self.points is not None:
            object.__setattr__(self, "points", _vector(self.points))
        if not (self.size > 0).all():
            raise ValueError(f"a {self.kind} needs a positive size, not {self.size}")

    @property
    def outline(self) -> np.ndarray:
        """`points` of a kind that has them. Raises ValueError for any other kind."""
        if self.points is None:
            raise ValueError(f"a {self.kind} has no points")
        return self.points

    def but(self, **changes: Any) -> Part:
        """Return the same part with some fields replaced."""
        if changes.keys() - _PLACE:
            return replace(self, **changes)
        # a form places its parts many times over, and a pose needs no checks
        made = object.__new__(Part)
        made.__dict__.update(self.__dict__)
        for name, value in changes.items():
            made.__dict__[name] = value if value is IDENTITY else _vector(value)
        return made


def about(axis: str, degrees: float) -> np.ndarray:
    """Rotation matrix (3, 3) of `degrees` about "x", "y" or "z", as right-handed mathematics writes it."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross product of two vectors (3,): numpy's own takes ten times as long for as few numbers."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def upright(direction: np.ndarray) -> np.ndarray:
    """Rotation matrix (3, 3) that takes +y to `direction` (any length) and turns as little as it can."""
    y = np.asarray(direction, dtype=float)
    y = y / np.linalg.norm(y)
    aside = np.array([0.0, 0.0, 1.0]) if abs(y[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = cross(y, aside)
    x /= np.linalg.norm(x)
    return np.stack([x, y, cross(x, y)], axis=1)


def span(low: Iterable[float], high: Iterable[float], slot: str = "main", **fields: Any) -> Part:
    """Return the axis-aligned box (or other `kind`) from corner `low` to corner `high`."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return Part(fields.pop("kind", "box"), (low + high) / 2, high - low, slot=slot, **fields)


def bar(
    start: Iterable[float], end: Iterable[float], width: float, depth: float | None = None, slot: str = "main", **fields: Any
) -> Part:
    """Return a beam (or other `kind`) from `start` to `end` of section `width` x `depth` (width if None), metres.

    An upright beam has its width along x and its depth along z; a level one stands on edge: its width is upright.
    """
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    length = float(np.linalg.norm(end - start))
    size = (width, length, width if depth is None else depth)
    return Part(fields.pop("kind", "box"), (start + end) / 2, size, upright(end - start), slot, **fields)


def rod(start: Iterable[float], end: Iterable[float], radius: float, slot: str = "main", **fields: Any) -> Part:
    """Return a cylinder (or other `kind`) of `radius` whose axis runs from `start` to `end`."""
    return bar(start, end, 2 * radius, slot=slot, kind=fields.pop("kind", "cylinder"), **fields)


def column(x: float, z: float, low: float, high: float, radius: float, slot: str = "main", **fields: Any) -> Part:
    """Return an upright cylinder (or other `kind`) at (x, z) from height `low` to `high`."""
    return span(
        (x - radius, low, z - radius), (x + radius, high, z + radius), slot, kind=fields.pop("kind", "cylinder"), **fields
    )


def lathe(profile: Iterable[tuple[float, float]], x: float = 0.0, z: float = 0.0, slot: str = "main", **fields: Any) -> Part:
    """`profile` [(radius, height), ...] revolved about the vertical through (x, z). Heights are kept."""
    points = np.array(list(profile), dtype=float)
    low, high = points[:, 1].min(), points[:, 1].max()
    radius = points[:, 0].max()
    middle = (low + high) / 2
    stretch = fields.pop("stretch", (1.0, 1.0))
    return Part(
        "lathe",
        (x, middle, z),
        (2 * radius * stretch[0], high - low, 2 * radius * stretch[1]),
        slot=slot,
        points=points - [0.0, middle],
        **fields,
    )


def prism(outline: Iterable[tuple[float, float]], z_low: float, z_high: float, slot: str = "main", **fields: Any) -> Part:
    """Return a convex `outline` [(x, y), ...], counter-clockwise seen from +z, extruded from `z_low` to `z_high`."""
    points = np.array(list(outline), dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    return Part(
        "prism",
        (*middle, (z_low + z_high) / 2),
        (*(high - low), z_high - z_low),
        slot=slot,
        points=points - middle,
        **fields,
    )


def tube(path: Iterable[Iterable[float]], radius: float, slot: str = "metal", **fields: Any) -> Part:
    """Return a round rod of `radius` along `path` [(x, y, z), ...]."""
    points = np.array(list(path), dtype=float)
    low, high = points.min(axis=0) - radius, points.max(axis=0) + radius
    middle = (low + high) / 2
    return Part("tube", middle, high - low, slot=slot, points=points - middle, ratio=radius, **fields)


def arc(
    centre: Iterable[float], radius: float, first_deg: float, last_deg: float, plane: str = "xy", count: int = 9
) -> np.ndarray:
    """Points (count, 3) of an arc about `centre` in `plane`, from angle to angle."""
    angle = np.radians(np.linspace(first_deg, last_deg, count))
    points = np.tile(np.array(centre, dtype=float), (count, 1))
    points[:, "xyz".index(plane[0])] += radius * np.cos(angle)
    points[:, "xyz".index(plane[1])] += radius * np.sin(angle)
    return points


def moved(parts: Iterable[Part], rotation: np.ndarray = IDENTITY, by: Iterable[float] = (0.0, 0.0, 0.0)) -> tuple[Part, ...]:
    """`parts` turned about the origin by `rotation` (3, 3), then shifted `by` (3,) metres."""
    shift = np.array(by, dtype=float)
    return tuple(p.but(centre=rotation @ p.centre + shift, rotation=rotation @ p.rotation) for p in parts)
