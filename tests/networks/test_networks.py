"""Small and large networks load and run by the same lines."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from ovman.perception import detector, encoder, networks, pytorch
from ovman.perception.weights import WeightsError
from ovman.settings.config import load_files
from ovman.shipped import HOME
from tests.networks import ultralytics_own

pytestmark = [pytest.mark.networks, pytest.mark.usefixtures("one_tokenizer")]
TOWERS = {
    "embed_dim": 8,
    "vision_cfg": {"image_size": 32, "layers": [1, 1, 1, 1], "width": 8, "patch_size": None},
    "text_cfg": {"context_length": 12, "vocab_size": 49408, "width": 16, "heads": 2, "layers": 1},
}
FRAMES = list(np.random.default_rng(0).integers(0, 256, (3, 90, 120, 3), np.uint8))


def perception(detector_weights: Path, encoder_weights: Path, model: str, architecture: str = "yolov8n-seg", side_px: int = 64):
    return SimpleNamespace(
        device="cpu",
        trust_pickles=False,
        detector=SimpleNamespace(
            architecture=architecture,
            weights=str(detector_weights),
            sha256="",
            side_px=side_px,
            confidence=0.25,
            min_mask_px=20,
        ),
        encoder=SimpleNamespace(model=model, weights=str(encoder_weights), sha256="", crop_padding=0.1),
    )


def seeing(architecture: str, path: Path, classes: int = 1) -> Path:
    """Weights drawn at random of a network that finds something in everything."""
    torch.manual_seed(0)
    network = pytorch.empty_detector(architecture, classes)
    for scores in network.model[-1].cv3:
        torch.nn.init.normal_(scores[-1].weight, std=0.5)
        torch.nn.init.constant_(scores[-1].bias, 0.0)
    save_file({name: value.half().contiguous() for name, value in network.state_dict().items()}, path)
    return path


def drawn(model: str, path: Path) -> Path:
    """Random weights of towers: a million numbers, as often as they are needed. Drawing 150 million takes seconds."""
    torch.manual_seed(0)
    with torch.device("meta"):
        shapes = {
            name: value.shape for name, value in pytorch.empty_towers(pytorch.read_architecture(model)).state_dict().items()
        }
    some = torch.randn(1 << 20).half() / 50
    most = some.repeat(-(-max(shape.numel() for shape in shapes.values()) // len(some)))
    again = {name: most[: shape.numel()].reshape(shape) for name, shape in shapes.items()}
    # A variance is not negative.
    save_file({name: one.abs() if name.endswith("running_var") else one.clone() for name, one in again.items()}, path)
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> SimpleNamespace:
    directory = tmp_path_factory.mktemp("small")
    model = directory / "towers.json"
    model.write_text(json.dumps(TOWERS))
    return perception(
        seeing("yolov8n-seg", directory / "d.safetensors"), drawn(str(model), directory / "e.safetensors"), str(model)
    )


def test_a_small_detector_finds_masks_of_the_pictures_size_surest_first_and_the_same_again(small):
    found = networks.detector_of(small).detect(FRAMES)
    assert len(found) == 3 and sum(len(one.masks) for one in found) > 0
    for one in found:
        assert one.masks.dtype == bool and one.masks.shape == (len(one.confidence), 90, 120)
        assert (one.confidence > 0.25).all() and (np.diff(one.confidence) <= 0).all() and len(one.masks) <= detector.AT_MOST
        assert one.masks.any(axis=(1, 2)).all()
    again = networks.detector_of(small).detect(FRAMES)
    assert all(
        np.array_equal(a.masks, b.masks) and np.array_equal(a.confidence, b.confidence) for a, b in zip(found, again, strict=True)
    )


def test_classes_are_not_told_apart(tmp_path):
    """Of boxes that overlap one stays, whatever their classes are."""
    path = seeing("yolov8n-seg", tmp_path / "many.safetensors", classes=7)
    network = pytorch.load_detector(path, "yolov8n-seg")
    assert network.model[-1].nc == 7
    for box in network.model[-1].cv2:  # all boxes of a scale have one form
        torch.nn.init.zeros_(box[-1].weight)
    (agnostic,) = networks.loaded_detector(network, 64, 0.25).detect(FRAMES[:1])
    told_apart = ultralytics_own.predictor(network, 64, 0.25, agnostic_nms=False)
    (more,) = ultralytics_own.detect(told_apart, FRAMES[:1])
    assert 0 < len(agnostic.masks) < len(more.masks)


def test_embeddings_are_unit_vectors_one_for_each_and_the_same_in_any_company(small):
    both = networks.encoder_of(small)
    assert (both.side_px, both.size) == (32, 8)
    crops = np.random.default_rng(0).integers(0, 256, (encoder.TOGETHER + 2, 32, 32, 3), np.uint8)
    images = both.images(crops)
    texts = both.texts(["chair", "house plant", "chair"])
    for found in (images, texts):
        assert found.dtype == np.float32 and np.linalg.norm(found, axis=1) == pytest.approx(np.ones(len(found)), abs=1e-5)
    assert images.shape == (len(crops), 8) and np.array_equal(texts[0], texts[2]) and not np.allclose(texts[0], texts[1])
    assert both.images(crops[:1]) == pytest.approx(images[:1], abs=1e-5)
    assert np.array_equal(both.images(crops), images)
    assert both.images(crops[:0]).shape == (0, 8) and both.texts([]).shape == (0, 8)


def test_the_paper_s_networks_load_and_run_by_the_same_lines(tmp_path):
    named = load_files([str(HOME / "config.yaml"), str(HOME / "overlays" / "thor.yaml")]).perception
    assert (named.detector.architecture, named.detector.weights, named.detector.side_px) == ("yolov8m-seg", "yolov8m-seg.pt", 640)
    assert (named.encoder.model, named.encoder.weights) == ("ViT-B-16", "laion2b_s34b_b88k")
    assert named.device == "cuda" and named.trust_pickles is False
    large = perception(
        seeing(named.detector.architecture, tmp_path / "d.safetensors", classes=80),
        drawn(named.encoder.model, tmp_path / "e.safetensors"),
        named.encoder.model,
        named.detector.architecture,
        named.detector.side_px,
    )
    (found,) = networks.detector_of(large).detect(FRAMES[:1])
    assert len(found.masks) > 0 and found.masks.shape[1:] == (90, 120)
    both = networks.encoder_of(large)
    assert (both.side_px, both.size) == (224, 512)
    assert np.linalg.norm(both.images(np.zeros((1, 224, 224, 3), np.uint8))) == pytest.approx(1.0, abs=1e-5)
    assert np.linalg.norm(both.texts(["chair"])) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "has no towers"),
        ("{", "has no towers"),
        (json.dumps(TOWERS | {"embed_dim": "8"}), "has no towers"),
        (json.dumps(TOWERS | {"custom_text": True}), "custom_text is unknown here"),
        (json.dumps(TOWERS | {"text_cfg": {"hf_model_name": "x"}}), "hf_model_name is unknown here"),
    ],
)
def test_a_configuration_that_is_none_is_one_line(tmp_path, content, says):
    path = tmp_path / "towers.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(WeightsError, match=says) as caught:
        pytorch.read_architecture(str(path))
    assert "\n" not in str(caught.value) and str(caught.value).startswith("perception.encoder.model")


def test_a_network_that_there_is_not_is_one_line():
    for name in ("yolov8q-seg", "resnet50"):
        with pytest.raises(WeightsError, match=f"architecture is {name}"):
            pytorch.empty_detector(name)
    with pytest.raises(WeightsError, match="which open_clip does not have"):
        pytorch.read_architecture("ViT-Q-16")
