"""The instances in an image by their colours. The client makes a mask an instance, which takes as long as drawing the image."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

_COLOUR = 0xFFFFFF

Indexed = tuple[np.ndarray, list[str], dict[str, int]]
"""Index image (H, W) uint16 (0 nothing, k the k-th name), the names of the instances in it, and the sizes of their masks by name,
pixels."""


def coloured(masks: Any) -> tuple[np.ndarray, dict[str, int]]:
    """(H, W) int64 of an image's instance masks, as the client keeps them: a number a pixel, its colour; and the number of each
    instance by its id.

    The room's shell has numbers without an id. Ids may share a number, as colours are hashes.
    """
    numbers = masks.instance_segmentation_frame_uint32.astype(np.int64) & _COLOUR
    colours: Mapping[str, Sequence[int]] = masks.instance_colors
    return numbers, {name: red | green << 8 | blue << 16 for name, (red, green, blue, *_) in colours.items()}


def indexed(masks: Any, shape: tuple[int, int], min_mask_px: int) -> Indexed:
    """The instances in an image of a shape (H, W). Masks of fewer than `min_mask_px` pixels have no size.

    masks: of an event of the client, or of a recorded session, which knows no colours.
    """
    if not hasattr(masks, "instance_segmentation_frame_uint32"):
        return by_masks(masks, shape, min_mask_px)
    numbers, colours = coloured(masks)
    names = sorted(colours)
    found = np.array([colours[name] for name in names], np.int64)
    table = _table()
    table[found] = np.arange(1, len(names) + 1)  # of names of one colour the last stands in the image
    index = table[numbers]
    pixels = np.bincount(index.ravel(), minlength=len(names) + 1)[table[found]]
    table[found] = 0
    there = np.flatnonzero(pixels).tolist()
    place = np.zeros(len(names) + 1, np.uint16)
    place[[k + 1 for k in there]] = np.arange(1, len(there) + 1)
    return place[index], [names[k] for k in there], {names[k]: int(pixels[k]) for k in there if pixels[k] >= min_mask_px}


def by_masks(masks: Mapping[str, np.ndarray], shape: tuple[int, int], min_mask_px: int) -> Indexed:
    """`indexed` of masks (H, W) bool by name, one after the other."""
    names = sorted(masks.keys())
    index = np.zeros(shape, np.uint16)
    sizes = {}
    for k, name in enumerate(names, start=1):
        mask = masks[name]
        index[mask] = k
        size = int(np.count_nonzero(mask))
        if size >= min_mask_px:
            sizes[name] = size
    return index, names, sizes


@cache
def _table() -> np.ndarray:
    """(2 ** 24,) uint16, 0 for every colour; pages that nothing is written to take no memory."""
    return np.zeros(_COLOUR + 1, np.uint16)
