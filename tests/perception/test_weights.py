"""Which files are weights, and which are refused before they are opened."""

from __future__ import annotations

import hashlib
import pickle
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from ovman.perception.weights import detector_file, encoder_file, located, read_state, sha256
from ovman.shipped import HOME
from tests.perception.refused import line

KEY = "perception.detector"


class Trap:
    """A pickle that does something when it is opened."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("models/detector.safetensors", HOME / "models/detector.safetensors"),
        ("detector.safetensors", HOME / "detector.safetensors"),
        ("encoder.json", HOME / "encoder.json"),
        ("./mine.pt", HOME / "mine.pt"),
        ("/somewhere/mine.pt", Path("/somewhere/mine.pt")),
        ("yolov8m-seg.pt", None),
        ("ViT-B-16", None),
        ("laion2b_s34b_b88k", None),
    ],
)
def test_what_is_a_file_and_what_a_release(name, path):
    assert located(name) == path


def test_a_pickle_is_not_opened_before_its_user_says_so(tmp_path):
    sprung = tmp_path / "sprung"
    path = tmp_path / "mine.pt"
    path.write_bytes(pickle.dumps(Trap(sprung)))
    for call in (
        lambda: read_state(path, False, KEY),
        lambda: detector_file(str(path), False),
        lambda: encoder_file("ViT-B-16", str(path), False),
        lambda: detector_file("yolov8m-seg.pt", False),
    ):
        assert "set perception.trust_pickles to true" in line(call)
    assert not sprung.exists()


def test_what_is_no_file_is_one_line(tmp_path):
    assert "none.safetensors is missing; `make models`" in line(lambda: detector_file(str(tmp_path / "none.safetensors"), False))
    assert "perception.encoder.weights" in line(lambda: encoder_file("any", str(tmp_path / "none.safetensors"), False))
    assert "it must be a file" in line(lambda: detector_file("yolov8m-seg", True))


def test_bytes_are_held_to_the_digest_that_is_given(tmp_path):
    file = tmp_path / "mine.safetensors"
    save_file({"weight": np.ones((2, 3), np.float32)}, file)
    right = hashlib.sha256(file.read_bytes()).hexdigest()
    assert sha256(file) == right
    assert detector_file(str(file), False, right) == file
    assert f"is {right}, not {'0' * 64}" in line(lambda: detector_file(str(file), False, "0" * 64))
