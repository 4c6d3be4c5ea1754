"""Graphs give what the networks of torch give."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
import torch

from ovman.perception import detector, encoder
from ovman.perception.graph import Graph
from tests.perception.test_networks import FRAMES, TOWERS

TRANSFORMER = {**TOWERS["vision_cfg"], "layers": 2, "width": 16, "head_width": 8, "patch_size": 8}


def tower(vision: dict) -> torch.nn.Module:
    torch.manual_seed(0)
    towers = encoder.Architecture("small", {**TOWERS, "vision_cfg": vision, "quick_gelu": True}, (0.5,) * 3, (0.25,) * 3)
    return encoder.empty_network(towers).eval().visual


@pytest.mark.parametrize("vision", [TOWERS["vision_cfg"], TRANSFORMER], ids=["convolutions", "transformer"])
def test_a_tower_takes_any_number_of_crops(vision):
    network = tower(vision)
    crops = torch.randn(5, 3, 32, 32, generator=torch.Generator().manual_seed(1))
    graph = Graph(network, (0, 3, 32, 32))
    for number in (1, 2, 5):
        with torch.inference_mode():
            expected = network(crops[:number])
        (found,) = graph(crops[:number])
        assert found.shape == expected.shape and torch.allclose(found, expected, atol=1e-5)


def test_making_a_graph_leaves_the_network_as_it_was():
    network = tower(TRANSFORMER)
    before, fast = deepcopy(network.state_dict()), torch.backends.mha.get_fastpath_enabled()
    Graph(network, (0, 3, 32, 32))
    assert not any(module.training for module in network.modules())
    assert all(torch.equal(value, before[name]) for name, value in network.state_dict().items())
    assert torch.backends.mha.get_fastpath_enabled() == fast


@pytest.mark.parametrize("frames", [FRAMES, [frame[:, :90] for frame in FRAMES]], ids=["wide", "square"])
def test_a_detector_gives_what_its_network_gives(frames):
    torch.manual_seed(0)
    network = detector.empty_network("yolov8n-seg").eval()
    looks = detector.Detector(deepcopy(network), 64, 0.25)
    looks.detect(frames)
    pictures = torch.rand(3, 3, 64, 64, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        expected = network.fuse(verbose=False)(pictures)[0]
        (found,) = looks.network(pictures)
    for one, other in zip(found, expected, strict=True):
        assert one.shape == other.shape and np.allclose(one, other, rtol=1e-4, atol=1e-3)
