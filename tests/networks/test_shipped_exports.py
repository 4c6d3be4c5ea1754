"""The default's graphs give what PyTorch makes of the shipped weights."""

from __future__ import annotations

import hashlib
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ovman import seeds
from ovman.perception import encoder, networks, pytorch
from ovman.perception.graph import Graph
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from tests.networks import ultralytics_own
from training.encoder import embed_images
from training.export import detector_graph, main
from training.floorplans import floor_plans
from training.thresholds import take_views
from training.towers import load_image_tower

pytestmark = pytest.mark.networks
MODELS = HOME / "models"
CONFIG = load(HOME / "config.yaml")
SAME, LEAST_IOU = 0.99, 0.9
"""Least share of instances that both paths have, and IoU of one with its partner."""


def test_an_export_has_the_numbers_of_the_shipped_files():
    """Not the bytes: another release of torch may write another graph."""
    rng = np.random.default_rng(0)
    path = MODELS / "detector.safetensors"
    made = Graph(detector_graph(pytorch.load_detector(path, CONFIG.perception.detector.architecture), path))
    for side_px in (224, 320):
        frame = rng.random((1, 3, side_px, side_px), np.float32)
        for one, other in zip(made(frame), Graph((MODELS / "detector.onnx").read_bytes())(frame), strict=True):
            assert np.allclose(one, other, rtol=1e-4, atol=1e-3)


def test_the_image_tower_of_eight_bits_embeds_as_its_weights_do():
    """On views of a floor plan of which no picture was trained on."""
    ours, tower = networks.encoder_of(CONFIG.perception), load_image_tower(MODELS / "encoder.safetensors")
    scene = floor_plans(CONFIG.splits["main"].scenes).held_out[0]
    with Session(scene, CONFIG, Embodiment.named("default", CONFIG)) as session:
        pictures = [picture for picture, _ in take_views(session, 4, seeds.generator(0, "graphs", scene))]
    masks = [(p.rgb, p.ids == n) for p in pictures for n in np.flatnonzero(p.sizes() >= 300)]
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
    """In six views of a floor plan of which no picture was trained on."""
    scene, each = floor_plans(CONFIG.splits["main"].scenes).held_out[0], 6
    settings = CONFIG.perception.detector
    path = MODELS / "detector.safetensors"
    own = ultralytics_own.predictor(pytorch.load_detector(path, settings.architecture), settings.side_px, settings.confidence)
    ours, body = networks.detector_of(CONFIG.perception), Embodiment.named("default", CONFIG)
    counts = np.zeros(3, int)
    with Session(scene, CONFIG, body) as session:
        pictures = [picture.rgb for picture, _ in take_views(session, each, seeds.generator(0, "graphs", scene))]
    for one, other in zip(ours.detect(pictures), ultralytics_own.detect(own, pictures), strict=True):
        counts += len(one.masks), len(other.masks), ultralytics_own.shared(one, other, LEAST_IOU)
    mine, theirs, both = counts.tolist()
    assert theirs > each and both >= SAME * max(mine, theirs)


def test_an_export_is_run_from_its_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(HOME)
    main(["--out", str(tmp_path / "made")])
    path = tmp_path / "made" / "detector.onnx"
    assert hashlib.sha256(path.read_bytes()).hexdigest() in capsys.readouterr().out
    finds = CONFIG.perception.detector.model_copy(update={"weights": str(path)})
    made = networks.detector_of(SimpleNamespace(device="cpu", trust_pickles=False, detector=finds))
    assert len(made.detect([np.zeros((300, 300, 3), np.uint8)])) == 1
