"""Images of frames: PNG files (ISO/IEC 15948), and the instances in an image by their colours.

PNG files are written fast: one filter for all rows and Intel's deflate. OpenCV takes three times as long for files of equal size.
The client turns one mask per instance into an array, which takes as long as drawing the image.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from isal import isal_zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"
UP = 2
"""The filter of all rows: the difference from the row above. Files are hardly larger than with the best filter per row."""
LEVEL = 1
"""Of deflate. Level 0 makes files a sixth larger, level 2 at most 1 % smaller."""
_GREY, _COLOURS = 0, 2


def write_png(path: Path, image: np.ndarray) -> None:
    """Write an image (H, W) of 8 or 16 bit, or (H, W, 3) uint8 in the order red, green, blue."""
    path.write_bytes(encode_png(image))


def encode_png(image: np.ndarray) -> bytes:
    """Return the file of an image. ValueError for an image of other numbers or another shape."""
    if image.dtype not in (np.uint8, np.uint16) or image.shape[2:] not in ((), (3,)) or image.ndim < 2 or not image.size:
        raise ValueError(f"an image of shape {image.shape} and numbers {image.dtype} cannot be written as PNG")
    height, width = image.shape[:2]
    rows = np.ascontiguousarray(image, image.dtype.newbyteorder(">")).view(np.uint8).reshape(height, -1)
    filtered = np.empty((height, rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = UP
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    header = struct.pack(">IIBBBBB", width, height, 8 * image.dtype.itemsize, _COLOURS if image.ndim == 3 else _GREY, 0, 0, 0)
    parts = (b"IHDR", header), (b"IDAT", isal_zlib.compress(filtered.data, LEVEL)), (b"IEND", b"")
    return SIGNATURE + b"".join(_chunk(kind, content) for kind, content in parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


_COLOUR = 0xFFFFFF

Indexed = tuple[np.ndarray, list[str], dict[str, int]]
"""Index image (H, W) uint16 (0 nothing, k the k-th name), names of the instances in it, and sizes of their masks in pixels."""


def colour_numbers(masks: Any) -> tuple[np.ndarray, dict[str, int]]:
    """Return (H, W) int64 with a number per pixel, its colour, and the number of each instance by id.

    masks: of an event of the client. The shell of the room has numbers without an id. Ids may share a number: colours are hashes.
    """
    numbers = masks.instance_segmentation_frame_uint32.astype(np.int64) & _COLOUR
    colours: Mapping[str, Sequence[int]] = masks.instance_colors
    return numbers, {name: red | green << 8 | blue << 16 for name, (red, green, blue, *_) in colours.items()}


def index_instances(masks: Any, min_mask_px: int) -> Indexed:
    """Return the instances in an image. masks: of an event of the client. Masks below `min_mask_px` pixels have no size."""
    numbers, colours = colour_numbers(masks)
    names = sorted(colours)
    found = np.array([colours[name] for name in names], np.int64)
    table = _table()
    table[found] = np.arange(1, len(names) + 1)  # of several names of one colour the image has the last
    index = table[numbers]
    pixels = np.bincount(index.ravel(), minlength=len(names) + 1)[table[found]]
    table[found] = 0
    there = np.flatnonzero(pixels).tolist()
    place = np.zeros(len(names) + 1, np.uint16)
    place[[k + 1 for k in there]] = np.arange(1, len(there) + 1)
    return place[index], [names[k] for k in there], {names[k]: int(pixels[k]) for k in there if pixels[k] >= min_mask_px}


@cache
def _table() -> np.ndarray:
    """Return (2 ** 24,) uint16, 0 for every colour; pages without a write take no memory."""
    return np.zeros(_COLOUR + 1, np.uint16)
