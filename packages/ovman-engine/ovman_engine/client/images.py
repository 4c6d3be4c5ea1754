"""Images in AI2-THOR's wire format: raw, rows from the bottom up, with colours that identify instances and classes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ovman_engine.client.settings import Images
from ovman_engine.client.wire import Field

if TYPE_CHECKING:
    from ovman_engine.picture.camera import Frame, View


class Fields(NamedTuple):
    """Frame types of one camera's images."""

    colour: Field
    depth: Field
    normals: Field
    instances: Field
    classes: Field


AGENT = Fields(Field.RGB, Field.DEPTH, Field.NORMALS, Field.IDS, Field.CLASSES)
THIRD_PARTY = Fields(
    Field.THIRD_PARTY_RGB,
    Field.THIRD_PARTY_DEPTH,
    Field.THIRD_PARTY_NORMALS,
    Field.THIRD_PARTY_IDS,
    Field.THIRD_PARTY_CLASSES,
)
OPAQUE = 0xFF000000
BACKGROUND = np.uint32(OPAQUE)
"""Colour of pixels without an instance; no instance has it."""


@lru_cache(maxsize=4096)
def colour(tag: str) -> tuple[int, int, int]:
    """Colour (r, g, b), 0 to 255, of an instance or a class in segmentation images: a hash of its name."""
    red, green, blue = hashlib.md5(tag.encode("utf8"), usedforsecurity=False).digest()[:3]
    return red, green, blue


def class_of(name: str) -> str:
    """Class of an instance: "Chair" of Chair|+01.00|+00.00|-02.00, "SinkBasin" of Sink|+01.00|+00.90|-02.00|SinkBasin."""
    first, last = name.split("|", 1)[0], name.rsplit("|", 1)[-1]
    return last if last[:1].isalpha() else first


@lru_cache(maxsize=16)
def colour_table(names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return the metadata's `colors`: one entry for each instance in `names` and for each of their classes.

    The list is cached: do not change it.
    """
    tags = list(dict.fromkeys([*names, *map(class_of, names)]))
    return [{"name": tag, "color": list(colour(tag))} for tag in tags]


@lru_cache(maxsize=16)
def _palette(names: tuple[str, ...], classes: bool) -> np.ndarray:
    """(N + 1,) uint32 little-endian RGBA. The background comes last, so that index -1 selects it."""
    tags = [class_of(n) if classes else n for n in names]
    packed = [r | g << 8 | b << 16 | OPAQUE for r, g, b in map(colour, tags)]
    return np.array([*packed, BACKGROUND], dtype="<u4")


def encoded(
    frame: Frame, names: Sequence[str], view: View, wanted: Images, fields: Fields = AGENT
) -> list[tuple[Field, memoryview]]:
    """Return the `wanted` images of `frame` in wire format. `names` are the instances that its ids number."""
    images: list[tuple[Field, np.ndarray]] = []
    if wanted.colour and frame.rgb is not None:
        images.append((fields.colour, frame.rgb))
    if wanted.depth and frame.depth is not None:
        images.append((fields.depth, frame.depth))
    if wanted.normals and frame.normals is not None:
        images.append((fields.normals, _normals(frame.normals, view)))
    if wanted.classes:
        images.append((fields.classes, _palette(tuple(names), True)[frame.ids]))
    if wanted.instances:
        images.append((fields.instances, _palette(tuple(names), False)[frame.ids]))
    return [(field, np.ascontiguousarray(image[::-1]).data) for field, image in images]


def _normals(world: np.ndarray, view: View) -> np.ndarray:
    """Return normals (H, W, 3) in the world frame as (H, W, 3) uint8 in the camera's: x right, y up, z towards the camera."""
    axes = (view.axes() * [[1.0], [1.0], [-1.0]]).astype(np.float32)
    return np.round((world @ axes.T + 1.0) * 127.5).astype(np.uint8)
