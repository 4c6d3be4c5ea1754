"""Images: PNG files that another library reads, and the instances in an image by colour and by mask."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from ai2thor.server import LazyInstanceSegmentationMasks
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ovman.sim.images import encode_png, index_instances

SIDE = 24


def client_masks(names: dict[str, list[int]], pixels: np.ndarray) -> LazyInstanceSegmentationMasks:
    """The client's masks of an image whose pixels (SIDE, SIDE, 3) are colours; it is sent with rows from the bottom up."""
    image = np.concatenate([pixels, np.full((SIDE, SIDE, 1), 255)], axis=2).astype(np.uint8)[::-1]
    colors = [{"name": name, "color": colour} for name, colour in names.items()]
    return LazyInstanceSegmentationMasks(image.tobytes(), {"screenWidth": SIDE, "screenHeight": SIDE, "colors": colors})


def by_masks(masks, shape, min_mask_px):
    """The same of masks (H, W) bool by name, one after the other."""
    names = sorted(masks.keys())
    index, sizes = np.zeros(shape, np.uint16), {}
    for k, name in enumerate(names, start=1):
        index[masks[name]] = k
        if (size := int(np.count_nonzero(masks[name]))) >= min_mask_px:
            sizes[name] = size
    return index, names, sizes


@given(st.integers(0, 2**32 - 1))
def test_by_colour_as_by_mask(seed: int) -> None:
    rng = np.random.default_rng(seed)
    colours = rng.integers(0, 256, (12, 3))
    colours[3] = colours[7]  # two names of one colour
    names = {f"Thing{k:02d}|{k}": colour.tolist() for k, colour in enumerate(colours[:9])} | {"Thing": colours[10].tolist()}
    pixels = colours[rng.integers(0, 12, (SIDE, SIDE)) if seed % 2 else rng.integers(5, 12, (SIDE, SIDE))]
    least = int(rng.integers(1, 80))
    found = index_instances(client_masks(names, pixels), least)
    expected = by_masks(client_masks(names, pixels), (SIDE, SIDE), least)
    assert found[0].dtype == expected[0].dtype and np.array_equal(found[0], expected[0])
    assert found[1:] == expected[1:] and list(found[2]) == list(expected[2])
    assert "Thing" not in found[1] and len(found[1]) >= 3


SIDES = st.integers(1, 12)
IMAGES = st.one_of(
    arrays.arrays(np.uint8, st.tuples(SIDES, SIDES, st.just(3))),
    arrays.arrays(np.uint8, st.tuples(SIDES, SIDES)),
    arrays.arrays(np.uint16, st.tuples(SIDES, SIDES)),
)


def decoded(content: bytes) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    return image[..., ::-1] if image.ndim == 3 else image


@given(IMAGES)
def test_another_library_reads_what_was_written(image):
    for picture in (image, np.flipud(image), np.asfortranarray(image)):
        back = decoded(encode_png(picture))
        assert back.dtype == image.dtype and back.shape == image.shape and (back == picture).all()


@pytest.mark.parametrize(
    "image", [np.zeros((2, 2), np.float32), np.zeros((2, 2, 4), np.uint8), np.zeros(3, np.uint8), np.zeros((0, 2), np.uint8)]
)
def test_what_is_no_such_picture_is_refused(image):
    with pytest.raises(ValueError, match="cannot be written as PNG"):
        encode_png(image)
