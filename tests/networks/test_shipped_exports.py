"""The default's graphs and phrases equal what ultralytics and open_clip make of the shipped weights."""

from __future__ import annotations

import hashlib
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ovman import seeds
from ovman.agents.cow.localiser import prompt
from ovman.language.vocabulary import all_nouns
from ovman.perception import encoder, networks, pytorch
from ovman.perception.encoder import Phrases
from ovman.perception.graph import Graph
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from tests.networks import ultralytics_own
from training.export import detector_graph, embed_phrases, main
from training.floorplans import floor_plans
from training.thresholds import take_views

pytestmark = [pytest.mark.networks, pytest.mark.usefixtures("one_tokenizer")]
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


@pytest.mark.parametrize("every", [8, pytest.param(1, marks=pytest.mark.soak)])
def test_embeddings_are_open_clip_s(every):
    path = MODELS / "encoder.safetensors"
    of = pytorch.read_architecture("models/encoder.json")
    network = pytorch.load_towers(path, of).eval()
    ours = networks.encoder_of(CONFIG.perception)
    crops = np.random.default_rng(0).integers(0, 256, (encoder.TOGETHER + 3, 64, 64, 3), np.uint8)
    pictures = torch.from_numpy(crops).permute(0, 3, 1, 2).float().div(255)
    mean, deviation = (torch.tensor(facts).view(1, 3, 1, 1) for facts in (of.mean, of.deviation))
    with torch.inference_mode():
        expected = network.encode_image((pictures - mean) / deviation, normalize=True).numpy()
    assert np.allclose(ours.images(crops), expected, atol=2e-6)

    shipped = Phrases.read(MODELS / "encoder.phrases.npz")
    some = [pytorch.embed_texts(network, of, [phrase]) for phrase in shipped.phrases[::every]]
    assert np.allclose(np.concatenate(some), shipped.feature[::every], atol=2e-6)
    known, _ = embed_phrases(lambda phrases: np.zeros((len(phrases), ours.size)), ["a thing of the user's"])
    assert known == (*shipped.phrases, "a thing of the user's")
    assert {*all_nouns(), prompt("HousePlant"), prompt("Floor")} <= {*known}


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


def test_an_export_is_run_from_its_files(tmp_path, monkeypatch, capsys):
    """With phrases of the user's."""
    monkeypatch.chdir(HOME)
    (tmp_path / "phrases.txt").write_text("a zeppelin\n\nchair\n")
    main(["--out", str(tmp_path / "made"), "--phrases", str(tmp_path / "phrases.txt")])
    said = capsys.readouterr().out
    found = Phrases.read(tmp_path / "made" / "encoder.phrases.npz")
    assert found.phrases[-1] == "a zeppelin" and found.phrases.count("chair") == 1
    for name in ("detector.onnx", "encoder.onnx"):
        assert hashlib.sha256((tmp_path / "made" / name).read_bytes()).hexdigest() in said
    names = CONFIG.perception.encoder.model_copy(update={"weights": str(tmp_path / "made" / "encoder.onnx")})
    made = networks.encoder_of(SimpleNamespace(device="cpu", trust_pickles=False, encoder=names))
    assert np.linalg.norm(made.texts(["a zeppelin"])) == pytest.approx(1.0, abs=1e-5)
