"""The instances in an image, at once by colour and one after the other by mask."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from ai2thor.server import LazyInstanceSegmentationMasks

from ovman.sim.masks import by_masks, coloured, indexed

SIDE = 24


def client_masks(names: dict[str, list[int]], pixels: np.ndarray) -> LazyInstanceSegmentationMasks:
    """The client's masks of an image whose pixels (SIDE, SIDE, 3) are colours; it is sent with rows from the bottom up."""
    image = np.concatenate([pixels, np.full((SIDE, SIDE, 1), 255)], axis=2).astype(np.uint8)[::-1]
    colors = [{"name": name, "color": colour} for name, colour in names.items()]
    return LazyInstanceSegmentationMasks(image.tobytes(), {"screenWidth": SIDE, "screenHeight": SIDE, "colors": colors})


@pytest.mark.parametrize("seed", range(20))
def test_by_colour_as_by_mask(seed: int) -> None:
    rng = np.random.default_rng(seed)
    colours = rng.integers(0, 256, (12, 3))
    colours[3] = colours[7]  # two names of one colour
    names = {f"Thing{k:02d}|{k}": colour.tolist() for k, colour in enumerate(colours[:9])} | {"Thing": colours[10].tolist()}
    pixels = colours[rng.integers(0, 12, (SIDE, SIDE)) if seed % 2 else rng.integers(5, 12, (SIDE, SIDE))]
    least = int(rng.integers(1, 80))
    found = indexed(client_masks(names, pixels), (SIDE, SIDE), least)
    expected = by_masks(client_masks(names, pixels), (SIDE, SIDE), least)
    assert found[0].dtype == expected[0].dtype and np.array_equal(found[0], expected[0])
    assert found[1:] == expected[1:] and list(found[2]) == list(expected[2])
    assert "Thing" not in found[1] and len(found[1]) >= 3


def test_an_image_of_nothing() -> None:
    masks = client_masks({"Thing|1": [1, 2, 3]}, np.zeros((SIDE, SIDE, 3), np.int64))
    index, names, sizes = indexed(masks, (SIDE, SIDE), 1)
    assert not index.any() and names == [] and sizes == {}


def test_masks_without_colours_are_taken_one_by_one() -> None:
    mask = np.zeros((SIDE, SIDE), bool)
    mask[2:5] = True
    index, names, sizes = indexed({"Thing|1": mask}, (SIDE, SIDE), 1)
    assert np.array_equal(index == 1, mask) and names == ["Thing|1"] and sizes == {"Thing|1": 3 * SIDE}


def test_the_opaque_byte_is_no_part_of_a_colour() -> None:
    frame = np.array([[0xFF030201]], np.uint32)
    numbers, colours = coloured(SimpleNamespace(instance_segmentation_frame_uint32=frame, instance_colors={"A|1": [1, 2, 3]}))
    assert numbers.tolist() == [[colours["A|1"]]]
