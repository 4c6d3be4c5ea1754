"""The default's graphs and phrases are what ultralytics and open_clip make of the weights beside them, and run without either."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ovman.agents.cow.relevance import prompt
from ovman.cli import main
from ovman.export.phrases import embedded
from ovman.kernels import runs_one_kernel
from ovman.language.vocabulary import all_nouns
from ovman.perception import encoder, exporting, networks, towers, weights, yolo
from ovman.perception.graph import Graph
from ovman.perception.phrases import Phrases
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from ovman.training.floorplans import floor_plans
from ovman.training.localisation import views
from ovman.workflow import seeds
from ovman.workflow.config import load
from tests.perception import ultralytics_own
from tests.perception.refused import line

pytestmark = pytest.mark.usefixtures("one_tokenizer")
MODELS = HOME / "models"
CONFIG = load(HOME / "config.yaml")
SAME, LEAST_IOU = 0.99, 0.9
"""Least share of instances that both paths have, and IoU of one with its partner."""
BITS = {"detector": "fe43ca1794ed35a3", "encoder": "fcfd5eee35edbd94"}
"""Digests of outputs, of ONNX Runtime 1.28; another release may sum otherwise."""


def sha256(name: str) -> str:
    return hashlib.sha256((MODELS / name).read_bytes()).hexdigest()


def test_graphs_and_phrases_are_of_the_weights_beside_them():
    assert (
        CONFIG.perception.detector.weights == "models/detector.onnx"
        and CONFIG.perception.encoder.weights == "models/encoder.onnx"
    )
    for kind in ("detector", "encoder"):
        found = Graph((MODELS / f"{kind}.onnx").read_bytes()).description
        assert (found.kind, found.source) == (kind, sha256(f"{kind}.safetensors"))
        assert {"torch", "onnx"} < found.made.keys()
    assert Phrases.read(MODELS / "encoder.phrases.npz").source == sha256("encoder.safetensors")
    readme = (MODELS / "README.md").read_text()
    for name in ("detector.onnx", "encoder.onnx", "encoder.phrases.npz"):
        assert sha256(name) in readme


@pytest.mark.skipif(not runs_one_kernel(), reason="other sums are those of other instructions")
def test_the_networks_give_the_same_bits_on_every_processor_with_avx2():
    """The digests were met on a processor with AVX2 and, emulated, on one with AVX-512."""
    found = {}
    for kind, side in (("detector", 128), ("encoder", 64)):
        pattern = np.arange(3 * side * side, dtype=np.int64) ** 2 % 251
        picture = (pattern.reshape(1, 3, side, side) / 256).astype(np.float32)
        outputs = Graph((MODELS / f"{kind}.onnx").read_bytes())(picture)
        found[kind] = hashlib.sha256(b"".join(one.tobytes() for one in outputs)).hexdigest()[:16]
    assert found == BITS


def test_an_export_has_the_numbers_of_the_shipped_files():
    """Not the bytes: another release of torch may write another graph."""
    rng = np.random.default_rng(0)
    path = MODELS / "detector.safetensors"
    made = Graph(exporting.detector_graph(yolo.network_of(path, CONFIG.perception.detector.architecture), path))
    for side_px in (224, 320):
        frame = rng.random((1, 3, side_px, side_px), np.float32)
        for one, other in zip(made(frame), Graph((MODELS / "detector.onnx").read_bytes())(frame), strict=True):
            assert np.allclose(one, other, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("every", [8, pytest.param(1, marks=pytest.mark.soak)])
def test_embeddings_are_open_clip_s(every):
    path = MODELS / "encoder.safetensors"
    of = towers.architecture("models/encoder.json")
    network = towers.network_of(path, of).eval()
    ours = networks.encoder_of(CONFIG.perception)
    crops = np.random.default_rng(0).integers(0, 256, (encoder.TOGETHER + 3, 64, 64, 3), np.uint8)
    pictures = torch.from_numpy(crops).permute(0, 3, 1, 2).float().div(255)
    mean, deviation = (torch.tensor(facts).view(1, 3, 1, 1) for facts in (of.mean, of.deviation))
    with torch.inference_mode():
        expected = network.encode_image((pictures - mean) / deviation, normalize=True).numpy()
    assert np.allclose(ours.images(crops), expected, atol=2e-6)

    shipped = Phrases.read(MODELS / "encoder.phrases.npz")
    some = [towers.texts(network, of, [phrase]) for phrase in shipped.phrases[::every]]
    assert np.allclose(np.concatenate(some), shipped.feature[::every], atol=2e-6)
    known, _ = embedded(lambda phrases: np.zeros((len(phrases), ours.size)), ["a thing of the user's"])
    assert known == (*shipped.phrases, "a thing of the user's")
    assert {*all_nouns(), prompt("HousePlant"), prompt("Floor")} <= {*known}


@pytest.mark.parametrize("size", [8, 11, 128, 512])
def test_unit_vectors_are_torch_s(size):
    features = np.random.default_rng(0).standard_normal((50, size)).astype(np.float32)
    features[0] = 0
    expected = torch.nn.functional.normalize(torch.from_numpy(features), dim=-1).numpy()
    assert np.allclose(encoder.unit(features), expected, rtol=3e-7, atol=0)


def compared(scenes: list[str], each: int) -> tuple[int, int, int]:
    """Instances of ours, of ultralytics' own path, and those that both have, in `each` views of floor plans."""
    settings = CONFIG.perception.detector
    path = MODELS / "detector.safetensors"
    own = ultralytics_own.predictor(yolo.network_of(path, settings.architecture), settings.side_px, settings.confidence)
    ours, body = networks.detector_of(CONFIG.perception), Embodiment.named("default", CONFIG)
    counts = np.zeros(3, int)
    for scene in scenes:
        with Session(scene, CONFIG, body) as session:
            pictures = [picture.rgb for picture, _ in views(session, each, seeds.generator(0, "graphs", scene))]
        for one, other in zip(ours.detect(pictures), ultralytics_own.detect(own, pictures), strict=True):
            counts += len(one.masks), len(other.masks), ultralytics_own.shared(one, other, LEAST_IOU)
    return int(counts[0]), int(counts[1]), int(counts[2])


def same(scenes: list[str], each: int) -> None:
    ours, own, both = compared(scenes, each)
    print(f"{len(scenes) * each} views: {ours} instances, {own} by ultralytics, {both} the same at IoU {LEAST_IOU}")
    assert own > each and both >= SAME * max(ours, own)


def test_detections_are_ultralytics_own():
    same(list(floor_plans(CONFIG.benchmark.scenes).held_out[:1]), 6)


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_detections_are_ultralytics_own_on_300_held_out_views():
    plans = list(floor_plans(CONFIG.benchmark.scenes).held_out)
    same(plans, -(-300 // len(plans)))


LOOKS = """
import sys
absent = sys.argv[3:]
sys.modules.update(dict.fromkeys(absent))
from pathlib import Path
import numpy as np
from ovman.workflow.config import load
settings = load(Path(sys.argv[1]))
if sys.argv[2] == "host":
    import ovman.remote.host
    from ovman.remote.looking import Looking
    detector, encoder = Looking(settings).networks
else:
    from ovman.evaluation import predictions, rollouts
    from ovman.perception.networks import detector_of, encoder_of
    detector, encoder = detector_of(settings.perception), encoder_of(settings.perception)
for side_px in (settings.perception.detector.side_px, settings.locobot.side_px):
    detector.at(side_px).detect([np.zeros((300, 300, 3), np.uint8)])
encoder.images(np.zeros((1, encoder.side_px, encoder.side_px, 3), np.uint8)), encoder.texts(["chair", "a photo of a chair"])
print([name for name in absent if sys.modules[name] is not None])
"""


@pytest.mark.parametrize("who", ["job", "host"])
def test_a_job_that_looks_imports_no_network_library(who, tmp_path):
    """Nor is one needed: they are not even there."""
    command = [sys.executable, "-c", LOOKS, str(HOME / "config.yaml"), who, *weights.EXTRA, "statsmodels"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=HOME)
    assert (done.returncode, done.stdout.strip()) == (0, "[]"), done.stderr


@pytest.fixture
def settings(tmp_path) -> SimpleNamespace:
    """Those of the default, with files of its own."""
    for name in ("detector.onnx", "encoder.onnx", "encoder.phrases.npz"):
        shutil.copy2(MODELS / name, tmp_path / name)
    finds = CONFIG.perception.detector.model_copy(update={"weights": str(tmp_path / "detector.onnx")})
    names = CONFIG.perception.encoder.model_copy(update={"weights": str(tmp_path / "encoder.onnx")})
    return SimpleNamespace(device="cpu", trust_pickles=False, detector=finds, encoder=names, folder=tmp_path)


@pytest.mark.parametrize("kind", ["detector", "encoder"])
def test_a_graph_that_is_none_is_one_line(settings, kind):
    make = {"detector": networks.detector_of, "encoder": networks.encoder_of}[kind]
    path, other = settings.folder / f"{kind}.onnx", {"detector": "encoder", "encoder": "detector"}[kind]
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert f"{kind}.onnx cannot be run: " in line(lambda: make(settings)) and "ovman export" in line(lambda: make(settings))
    path.write_bytes((MODELS / f"{other}.onnx").read_bytes())
    assert f"is the graph of the {other}; name that of the {kind}" in line(lambda: make(settings))
    path.unlink()
    assert "is missing" in line(lambda: make(settings))
    path.write_bytes(whole)
    settings.device = "cuda"
    assert "runs on a processor" in line(lambda: make(settings)) and "set it to cpu" in line(lambda: make(settings))


def test_a_phrase_without_an_embedding_is_one_line_with_its_remedy(settings):
    read = networks.encoder_of(settings).texts
    assert read([]).shape == (0, 128) and read(["chair", "sofa"]).shape == (2, 128)
    said = line(lambda: read(["chair", "a zeppelin"]))
    assert "encoder.phrases.npz has no embedding of 'a zeppelin'" in said and "ovman export --phrases" in said


@pytest.mark.parametrize("what", ["missing", "torn", "of other weights"])
def test_phrases_of_somebody_else_are_one_line(settings, what):
    table = settings.folder / "encoder.phrases.npz"
    if what == "missing":
        table.unlink()
    elif what == "torn":
        table.write_bytes(table.read_bytes()[:-10])
    else:
        Phrases(("chair",), np.zeros((1, 128), np.float32), "0" * 64, {}).write(table)
    said = line(lambda: networks.encoder_of(settings).texts(["chair"]))
    assert "encoder.phrases.npz" in said and {"missing": "is missing", "torn": "make it again"}.get(what, what) in said


def test_who_looks_is_told_by_graphs_and_phrases(settings):
    before = networks.looked_at_by(settings)
    assert json.loads(json.dumps(before)) == before and not {"torch", "ultralytics", "onnx"} & before["libraries"].keys()
    named = settings.detector.model_copy(update={"architecture": "yolov8m-seg"})
    assert networks.looked_at_by(SimpleNamespace(**vars(settings) | {"detector": named})) == before
    Phrases(("chair",), np.zeros((1, 128), np.float32), "0" * 64, {}).write(settings.folder / "encoder.phrases.npz")
    assert networks.looked_at_by(settings) != before


@pytest.mark.parametrize("device", ["cpu", "cuda"])
def test_an_extra_that_is_not_installed_is_one_line(settings, monkeypatch, tmp_path, device):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(weights.importlib.util, "find_spec", lambda name: None if name in ("torch", "ultralytics") else name)
    settings.device = device
    for kind, make in (("detector", networks.detector_of), ("encoder", networks.encoder_of)):
        path = str(MODELS / f"{kind}.safetensors")
        setattr(settings, kind, getattr(settings, kind).model_copy(update={"weights": path}))
        said = line(lambda make=make: make(settings))
        assert (
            f"perception.{kind}.weights" in said
            and "needs torch, ultralytics; in a checkout of OVMAN: pip install '.[networks]'" in said
        )


def test_an_export_is_run_from_its_files(tmp_path, monkeypatch, capsys):
    """With phrases of the user's, by the command."""
    monkeypatch.chdir(HOME)
    (tmp_path / "phrases.txt").write_text("a zeppelin\n\nchair\n")
    assert main(["export", "--out", str(tmp_path / "made"), "--phrases", str(tmp_path / "phrases.txt")]) == 0
    said = capsys.readouterr().out
    found = Phrases.read(tmp_path / "made" / "encoder.phrases.npz")
    assert found.phrases[-1] == "a zeppelin" and found.phrases.count("chair") == 1
    for name in ("detector.onnx", "encoder.onnx"):
        assert hashlib.sha256((tmp_path / "made" / name).read_bytes()).hexdigest() in said
    names = CONFIG.perception.encoder.model_copy(update={"weights": str(tmp_path / "made" / "encoder.onnx")})
    made = networks.encoder_of(SimpleNamespace(device="cpu", trust_pickles=False, encoder=names))
    assert np.linalg.norm(made.texts(["a zeppelin"])) == pytest.approx(1.0, abs=1e-5)
