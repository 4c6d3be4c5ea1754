"""Pictures as PNG files: read by another library, whatever is in them, and of one size with OpenCV's."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ovman.sim.png import encoded, write_png

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
        back = decoded(encoded(picture))
        assert back.dtype == image.dtype and back.shape == image.shape and (back == picture).all()


def test_files_are_small():
    rows, columns = np.mgrid[:300, :300]
    smooth = (1000 + 3 * rows + 2 * columns).astype(np.uint16)
    assert len(encoded(smooth)) < smooth.nbytes / 20


@pytest.mark.parametrize(
    "image", [np.zeros((2, 2), np.float32), np.zeros((2, 2, 4), np.uint8), np.zeros(3, np.uint8), np.zeros((0, 2), np.uint8)]
)
def test_what_is_no_such_picture_is_refused(image):
    with pytest.raises(ValueError, match="none that a PNG file is written of"):
        encoded(image)


def test_a_file_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(OSError, match="missing"):
        write_png(tmp_path / "missing" / "a.png", np.zeros((2, 2), np.uint8))
