"""Graphs give what the networks of torch give."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from ovman.perception import networks, pytorch
from ovman.perception.graph import Graph
from tests.networks import ultralytics_own
from tests.networks.test_networks import FRAMES, TOWERS, seeing
from training.export import encoder_graph

pytestmark = pytest.mark.networks
TRANSFORMER = {**TOWERS["vision_cfg"], "layers": 2, "width": 16, "head_width": 8, "patch_size": 8}


def architecture(vision: dict) -> pytorch.Architecture:
    return pytorch.Architecture("small", {**TOWERS, "vision_cfg": vision, "quick_gelu": True}, (0.5,) * 3, (0.25,) * 3)


def network(vision: dict) -> torch.nn.Module:
    torch.manual_seed(0)
    return pytorch.empty_towers(architecture(vision)).eval()


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "any.safetensors"
    path.write_bytes(b"weights")
    return path


@pytest.mark.parametrize("vision", [TOWERS["vision_cfg"], TRANSFORMER], ids=["convolutions", "transformer"])
def test_a_tower_takes_any_number_of_crops(vision, weights):
    of = network(vision)
    crops = np.random.default_rng(1).standard_normal((5, 3, 32, 32)).astype(np.float32)
    graph = Graph(encoder_graph(of, architecture(vision), weights))
    for number in (1, 2, 5):
        with torch.inference_mode():
            expected = of.visual(torch.from_numpy(crops[:number])).numpy()
        (found,) = graph(crops[:number])
        assert found.shape == expected.shape and np.allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize(("architecture", "classes"), [("yolov8n-seg", 1), ("yolov8n-seg", 7), ("yolo26n-seg", 3)])
def test_it_finds_what_ultralytics_finds_with_the_network(tmp_path, architecture, classes):
    """Whose suppression of overlaps is torchvision's, or the network's own."""
    path = seeing(architecture, tmp_path / "d.safetensors", classes)
    of = pytorch.load_detector(path, architecture)
    ours = networks.loaded_detector(of, 64, 0.25).detect(FRAMES)
    for one, other in zip(ours, ultralytics_own.detect(ultralytics_own.predictor(of, 64, 0.25), FRAMES), strict=True):
        assert one.masks.shape == other.masks.shape and len(one.confidence) == len(other.confidence) > 0
        assert np.allclose(one.confidence, other.confidence, atol=1e-3)
        if architecture != "yolo26n-seg":  # whose random weights find all equally sure, in any order
            assert (one.masks != other.masks).mean() < 1e-3
