"""Graphs give what the networks of torch give."""

from __future__ import annotations

import hashlib
from copy import deepcopy

import numpy as np
import onnx
import pytest
import torch
from onnx import TensorProto, helper, numpy_helper

from ovman.perception import exporting, networks, towers, yolo
from ovman.perception.graph import Graph, described
from ovman.perception.halved import halved
from tests.networks import ultralytics_own
from tests.networks.test_networks import FRAMES, TOWERS, seeing
from tests.perception.test_graph import DESCRIPTION

pytestmark = pytest.mark.networks
TRANSFORMER = {**TOWERS["vision_cfg"], "layers": 2, "width": 16, "head_width": 8, "patch_size": 8}


def architecture(vision: dict) -> towers.Architecture:
    return towers.Architecture("small", {**TOWERS, "vision_cfg": vision, "quick_gelu": True}, (0.5,) * 3, (0.25,) * 3)


def network(vision: dict) -> torch.nn.Module:
    torch.manual_seed(0)
    return towers.empty_network(architecture(vision)).eval()


def in_half(module: torch.nn.Module) -> torch.nn.Module:
    """With weights that half precision holds, as those of a file are, and factors of the layers that are fused."""
    module.load_state_dict({k: v.half().float() if v.is_floating_point() else v for k, v in module.state_dict().items()})
    return module


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "any.safetensors"
    path.write_bytes(b"weights")
    return path


@pytest.mark.parametrize("vision", [TOWERS["vision_cfg"], TRANSFORMER], ids=["convolutions", "transformer"])
def test_a_tower_takes_any_number_of_crops(vision, weights):
    of = network(vision)
    crops = np.random.default_rng(1).standard_normal((5, 3, 32, 32)).astype(np.float32)
    graph = Graph(exporting.encoder_graph(of, architecture(vision), weights))
    for number in (1, 2, 5):
        with torch.inference_mode():
            expected = of.visual(torch.from_numpy(crops[:number])).numpy()
        (found,) = graph(crops[:number])
        assert found.shape == expected.shape and np.allclose(found, expected, atol=1e-5)


def test_a_graph_says_what_it_is_and_what_it_was_made_of(weights):
    of = network(TRANSFORMER)
    found = Graph(exporting.encoder_graph(of, architecture(TRANSFORMER), weights)).description
    assert (found.kind, found.source) == ("encoder", hashlib.sha256(b"weights").hexdigest())
    assert found.facts == {"side_px": 32, "size": 8, "mean": [0.5] * 3, "deviation": [0.25] * 3}
    assert found.made.keys() == {"torch", "onnx", "open_clip_torch"}


def test_a_graph_leaves_its_network_as_it_was_and_is_the_same_when_it_is_made_again(weights):
    of = network(TRANSFORMER)
    before, fast = deepcopy(of.state_dict()), torch.backends.mha.get_fastpath_enabled()
    file = exporting.encoder_graph(of, architecture(TRANSFORMER), weights)
    assert file == exporting.encoder_graph(of, architecture(TRANSFORMER), weights)
    assert not any(module.training for module in of.modules())
    assert all(torch.equal(value, before[name]) for name, value in of.state_dict().items())
    assert torch.backends.mha.get_fastpath_enabled() == fast


def test_a_detector_gives_what_its_network_gives_for_frames_of_any_size(weights):
    torch.manual_seed(0)
    of = yolo.empty_network("yolov8n-seg").eval()
    graph = Graph(exporting.detector_graph(of, weights))
    for shape in ((64, 64), (96, 128), (32, 160)):
        picture = np.random.default_rng(1).random((1, 3, *shape), np.float32)
        with torch.inference_mode():
            expected = deepcopy(of).fuse(verbose=False)(torch.from_numpy(picture))[0]
        for part, other in zip(graph(picture), expected, strict=True):
            assert part.shape == other.shape and np.allclose(part, other, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize(("architecture", "classes"), [("yolov8n-seg", 1), ("yolov8n-seg", 7), ("yolo26n-seg", 3)])
def test_it_finds_what_ultralytics_finds_with_the_network(tmp_path, architecture, classes):
    """Whose suppression of overlaps is torchvision's, or the network's own."""
    path = seeing(architecture, tmp_path / "d.safetensors", classes)
    of = yolo.network_of(path, architecture)
    ours = networks.loaded_detector(of, path, 64, 0.25).detect(FRAMES)
    for one, other in zip(ours, ultralytics_own.detect(ultralytics_own.predictor(of, 64, 0.25), FRAMES), strict=True):
        assert one.masks.shape == other.masks.shape and len(one.confidence) == len(other.confidence) > 0
        assert np.allclose(one.confidence, other.confidence, atol=1e-3)
        if architecture != "yolo26n-seg":  # whose random weights find all equally sure, in any order
            assert (one.masks != other.masks).mean() < 1e-3


def small_graph(*arrays: np.ndarray) -> bytes:
    """pictures times the arrays, one after the other."""
    names = ["pictures", *(f"product{n}" for n in range(len(arrays)))]
    nodes = [helper.make_node("Mul", [names[n], f"w{n}"], [names[n + 1]]) for n in range(len(arrays))]
    made = helper.make_graph(
        nodes,
        "small",
        [helper.make_tensor_value_info("pictures", TensorProto.FLOAT, [1])],
        [helper.make_tensor_value_info(names[-1], TensorProto.FLOAT, None)],
        [numpy_helper.from_array(array, f"w{n}") for n, array in enumerate(arrays)],
    )
    return helper.make_model(made, opset_imports=[helper.make_opsetid("", 17)], ir_version=8).SerializeToString()


def test_halves_and_factors_have_the_same_numbers_in_half_the_bytes():
    rng = np.random.default_rng(0)
    weight = rng.standard_normal((16, 3, 9)).astype(np.float16)
    weight[3] = 0  # a channel without numbers
    factor = rng.lognormal(size=(16, 1, 1)).astype(np.float32)
    fused = weight.astype(np.float32) * factor
    exact = rng.standard_normal((16, 3, 9)).astype(np.float16).astype(np.float32)
    foreign = rng.standard_normal((16, 3, 9)).astype(np.float32)
    given = described(small_graph(fused, exact, foreign), DESCRIPTION)
    smaller = described(halved(small_graph(fused, exact, foreign), [weight]), DESCRIPTION)
    assert len(given) - len(smaller) > 2 * 2 * weight.size - 600
    kept = {one.name: numpy_helper.to_array(one) for one in onnx.load_from_string(smaller).graph.initializer}
    assert kept["w0.half"].dtype == kept["w1.half"].dtype == np.float16 and np.array_equal(kept["w2"], foreign)
    assert np.array_equal(kept["w0.half"].astype(np.float32) * kept["w0.factor"], fused)
    pictures = np.array([1.0], np.float32)
    assert np.array_equal(Graph(given)(pictures)[0], Graph(smaller)(pictures)[0])


def test_the_weights_of_a_detector_are_halved_and_its_outputs_are_not_changed(weights):
    torch.manual_seed(0)
    of = yolo.empty_network("yolov8n-seg").eval()
    for module in of.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            torch.nn.init.uniform_(module.running_var, 0.5, 2.0)
            torch.nn.init.uniform_(module.weight, 0.5, 2.0)
    in_half(of)
    whole = exporting.exported(yolo.running(of), (1, 3, 64, 64), (2, 3))
    half = exporting.detector_graph(of, weights)
    assert len(half) < 0.53 * len(whole)
    picture = np.random.default_rng(0).random((1, 3, 64, 96), np.float32)
    for one, other in zip(Graph(described(whole, DESCRIPTION))(picture), Graph(half)(picture), strict=True):
        assert np.array_equal(one, other)
