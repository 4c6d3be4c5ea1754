"""Files of weights are opened, refused and downloaded."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from ovman.perception import weights
from ovman.perception.weights import SHA256, detector_file, encoder_file, fit_weights, read_state
from tests.perception.refused import line

pytestmark = pytest.mark.networks
KEY = "perception.detector"


def test_a_file_of_tensors_is_opened_without_trust_and_fits_its_own_network(tmp_path):
    file = tmp_path / "mine.safetensors"
    save_file({"weight": torch.ones(2, 3), "bias": torch.zeros(2)}, file)
    assert detector_file(str(file), False) == file == encoder_file("any", str(file), False)
    state = read_state(file, False, KEY)
    assert {name: tuple(value.shape) for name, value in state.items()} == {"weight": (2, 3), "bias": (2,)}
    said = line(lambda: fit_weights(torch.nn.Linear(4, 2), state, file.name, KEY))
    assert said.startswith(f"perception.detector.weights: {file.name} does not fit perception.detector.architecture (")


@pytest.mark.parametrize("held", ["network", "tensors", "checkpoint", "average"])
def test_a_pickle_that_is_trusted_gives_its_tensors(tmp_path, held):
    network, other = torch.nn.Linear(3, 2).half(), torch.nn.Linear(3, 2)
    torch.save(
        {
            "network": network,
            "tensors": network.state_dict(),
            "checkpoint": {"model": network, "ema": None},
            "average": {"model": other, "ema": network},
        }[held],
        tmp_path / "mine.pt",
    )
    found = fit_weights(torch.nn.Linear(3, 2), read_state(tmp_path / "mine.pt", True, KEY), "mine.pt", KEY)
    assert found.weight.dtype == torch.float32 and torch.equal(found.weight, network.weight.float())


@pytest.mark.parametrize("name", ["spoilt.safetensors", "spoilt.pt", "list.pt"])
def test_a_file_that_holds_no_weights_is_one_line(tmp_path, name):
    path = tmp_path / name
    if name == "list.pt":
        torch.save([1, 2], path)
    else:
        path.write_bytes(b"nothing of the kind")
    assert name in line(lambda: read_state(path, True, KEY))


def test_an_asset_is_downloaded_once_and_held_to_its_recorded_digest(tmp_path, monkeypatch):
    from ultralytics.utils import downloads

    asked = []

    def deliver(path, release, **_):
        asked.append((Path(path).name, release))
        Path(path).write_bytes(b"what came")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(downloads, "attempt_download_asset", deliver)
    assert SHA256["yolov8m-seg.pt"] in line(lambda: detector_file("yolov8m-seg.pt", True))
    monkeypatch.setattr(weights, "SHA256", {"yolov8m-seg.pt": hashlib.sha256(b"what came").hexdigest()})
    path = detector_file("yolov8m-seg.pt", True)
    assert path.read_bytes() == b"what came" and path.is_relative_to(tmp_path)
    assert asked == [("yolov8m-seg.pt", weights.ASSETS_RELEASE)]


def test_what_does_not_arrive_is_one_line_with_its_remedy(tmp_path, monkeypatch):
    from open_clip import pretrained
    from ultralytics.utils import downloads

    def fail(*_, **__):
        raise ConnectionError("no route\nto the host")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(downloads, "attempt_download_asset", fail)
    monkeypatch.setattr(pretrained, "download_pretrained_from_hf", fail)
    for call in (lambda: detector_file("yolov8m-seg.pt", True), lambda: encoder_file("ViT-B-16", "laion2b_s34b_b88k", False)):
        text = line(call)
        assert "could not be downloaded (no route to the host)" in text and "give the file" in text


@pytest.mark.parametrize(
    ("model", "tag", "says"),
    [
        ("ViT-B-16", "laion3b", "not a tag of ViT-B-16; the nearest are laion400m_e32, "),
        ("ViT-Q-16", "laion2b_s34b_b88k", "open_clip does not have"),
        ("mine/encoder.json", "laion2b_s34b_b88k", "a model of your own"),
    ],
)
def test_a_tag_that_there_is_not_is_one_line(model, tag, says):
    said = line(lambda: encoder_file(model, tag, True))
    assert says in said and len(said) < 250
