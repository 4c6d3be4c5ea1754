"""The default's graphs give what PyTorch makes of the shipped weights."""

from __future__ import annotations

import hashlib
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ovman import seeds
from ovman.perception import encoder, networks, pytorch
from ovman.perception.detector import Detector
from ovman.perception.graph import Graph
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from tests.networks import ultralytics_own
from training.encoder import embed_images
from training.export import detector_graph, main
from training.floorplans import floor_plans
from training.pictures import Picture
from training.thresholds import take_views
from training.towers import load_image_tower

pytestmark = pytest.mark.networks
MODELS = HOME / "models"
CONFIG = load(HOME / "config.yaml")
SAME, LEAST_IOU = 0.99, 0.9
"""Least share of instances that both paths have, and IoU of one with its partner."""


def views(count: int) -> list[Picture]:
    """Pictures of a floor plan of which no picture was trained on."""
    scene = floor_plans(CONFIG.splits["main"].scenes).held_out[0]
    with Session(scene, CONFIG, Embodiment.named("default", CONFIG)) as session:
        return [picture for picture, _ in take_views(session, count, seeds.generator(0, "graphs", scene))]


def detector_of_weights() -> Detector:
    """The detector that PyTorch runs, in single precision."""
    settings = CONFIG.perception.detector
    network = pytorch.load_detector(MODELS / "detector.safetensors", settings.architecture)
    return networks.loaded_detector(network, settings.side_px, settings.confidence)


def shared_detections(one: Detector, other: Detector, least_iou: float) -> np.ndarray:
    """Numbers of instances of one, of the other, and of both, in six views."""
    pictures, counts = [picture.rgb for picture in views(6)], np.zeros(3, int)
    for mine, theirs in zip(one.detect(pictures), other.detect(pictures), strict=True):
        counts += len(mine.masks), len(theirs.masks), ultralytics_own.shared(mine, theirs, least_iou)
    return counts


def test_an_export_has_the_numbers_of_its_weights():
    rng = np.random.default_rng(0)
    path, settings = MODELS / "detector.safetensors", CONFIG.perception.detector
    network = pytorch.load_detector(path, settings.architecture)
    made, torch_s = Graph(detector_graph(network, path, settings.side_px)), detector_of_weights().network
    for side_px in (224, 320):
        frame = rng.random((1, 3, side_px, side_px), np.float32)
        for one, other in zip(made(frame), torch_s(frame), strict=True):
            assert np.allclose(one, other, rtol=1e-4, atol=1e-3)


def test_eight_bits_detect_what_the_weights_do():
    ours, exact, both = shared_detections(networks.detector_of(CONFIG.perception), detector_of_weights(), 0.7)
    assert exact > 12 and both >= 0.85 * max(ours, exact)


def test_the_image_tower_of_eight_bits_embeds_as_its_weights_do():
    ours, tower = networks.encoder_of(CONFIG.perception), load_image_tower(MODELS / "encoder.safetensors")
    masks = [(p.rgb, p.ids == n) for p in views(4) for n in np.flatnonzero(p.sizes() >= 300)]
    crops = np.stack([encoder.crop(rgb, mask, 0.1, ours.side_px, ours.contrast) for rgb, mask in masks])
    cosines = (ours.images(crops) * embed_images(tower, crops)).sum(axis=1)
    assert len(crops) > 5 and np.median(cosines) > 0.9


def test_the_text_tower_is_all_minilm():
    """In eight bits, and projected."""
    ours = networks.encoder_of(CONFIG.perception)
    seat, kin, other = ours.texts(["sofa", "couch", "lettuce"])
    assert seat @ kin > 0.5 > seat @ other + 0.2


@pytest.mark.parametrize("size", [8, 11, 128, 512])
def test_unit_vectors_are_torch_s(size):
    features = np.random.default_rng(0).standard_normal((50, size)).astype(np.float32)
    features[0] = 0
    expected = torch.nn.functional.normalize(torch.from_numpy(features), dim=-1).numpy()
    assert np.allclose(encoder.unit(features), expected, rtol=3e-7, atol=0)


def test_detections_are_ultralytics_own():
    settings = CONFIG.perception.detector
    network = pytorch.load_detector(MODELS / "detector.safetensors", settings.architecture)
    own = ultralytics_own.predictor(network, settings.side_px, settings.confidence)
    theirs = SimpleNamespace(detect=lambda pictures: ultralytics_own.detect(own, pictures))
    ours, there, both = shared_detections(detector_of_weights(), theirs, LEAST_IOU)
    assert there > 6 and both >= SAME * max(ours, there)


def test_an_export_is_run_from_its_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(HOME)
    main(["--out", str(tmp_path / "made")])
    path = tmp_path / "made" / "detector.onnx"
    assert hashlib.sha256(path.read_bytes()).hexdigest() in capsys.readouterr().out
    finds = CONFIG.perception.detector.model_copy(update={"weights": str(path)})
    made = networks.detector_of(SimpleNamespace(device="cpu", trust_pickles=False, detector=finds))
    assert len(made.detect([np.zeros((300, 300, 3), np.uint8)])) == 1
