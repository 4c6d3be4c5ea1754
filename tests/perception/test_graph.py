"""Graphs give what the networks of torch give."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
import torch

from ovman.perception import detector, encoder, predictor
from ovman.perception.graph import Graph, exported
from tests.perception.test_networks import FRAMES, TOWERS, seeing

TRANSFORMER = {**TOWERS["vision_cfg"], "layers": 2, "width": 16, "head_width": 8, "patch_size": 8}


def tower(vision: dict) -> torch.nn.Module:
    torch.manual_seed(0)
    towers = encoder.Architecture("small", {**TOWERS, "vision_cfg": vision, "quick_gelu": True}, (0.5,) * 3, (0.25,) * 3)
    return encoder.empty_network(towers).eval().visual


@pytest.mark.parametrize("vision", [TOWERS["vision_cfg"], TRANSFORMER], ids=["convolutions", "transformer"])
def test_a_tower_takes_any_number_of_crops(vision):
    network = tower(vision)
    crops = torch.randn(5, 3, 32, 32, generator=torch.Generator().manual_seed(1))
    graph = Graph(exported(network, (0, 3, 32, 32)))
    for number in (1, 2, 5):
        with torch.inference_mode():
            expected = network(crops[:number])
        (found,) = graph(crops[:number])
        assert found.shape == expected.shape and torch.allclose(found, expected, atol=1e-5)


def test_a_graph_leaves_its_network_as_it_was_and_is_the_same_when_it_is_made_again():
    network = tower(TRANSFORMER)
    before, fast = deepcopy(network.state_dict()), torch.backends.mha.get_fastpath_enabled()
    file = exported(network, (0, 3, 32, 32))
    assert file == exported(network, (0, 3, 32, 32))
    assert not any(module.training for module in network.modules())
    assert all(torch.equal(value, before[name]) for name, value in network.state_dict().items())
    assert torch.backends.mha.get_fastpath_enabled() == fast


@pytest.mark.parametrize("frames", [FRAMES, [frame[:, :90] for frame in FRAMES]], ids=["wide", "square"])
def test_a_detector_gives_what_its_network_gives(frames):
    torch.manual_seed(0)
    network = detector.empty_network("yolov8n-seg").eval()
    looks = detector.Detector(lambda: network, 64, 0.25)
    looks.detect(frames)
    pictures = torch.rand(3, 3, 64, 64, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        expected = network.fuse(verbose=False)(pictures)[0]
    found = looks.network(pictures)
    assert len(found) == len(pictures)
    for n, one in enumerate(found):
        for part, other in zip(one, expected, strict=True):
            assert part.shape == other[n : n + 1].shape and np.allclose(part, other[n : n + 1], rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize(("architecture", "classes"), [("yolov8n-seg", 1), ("yolov8n-seg", 7), ("yolo26n-seg", 3)])
def test_graphs_find_what_ultralytics_finds_with_the_network(tmp_path, architecture, classes):
    """Whose suppression of overlaps is torchvision's, or the network's own."""
    network = detector.network_of(seeing(architecture, tmp_path / "d.safetensors", classes), architecture)
    graphs, torchs = detector.Detector(lambda: network, 64, 0.25), detector.Detector(lambda: network, 64, 0.25)
    torchs._predict = predictor.with_network(graphs.options, deepcopy(network))
    for one, other in zip(graphs.detect(FRAMES), torchs.detect(FRAMES), strict=True):
        assert len(one.confidence) == len(other.confidence) > 0
        assert np.allclose(one.confidence, other.confidence, atol=1e-3)
        if architecture != "yolo26n-seg":  # whose random weights find all equally sure, in any order
            assert (one.masks != other.masks).mean() < 1e-3
