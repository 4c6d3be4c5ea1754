"""The default's graphs belong to the shipped weights, and run without ultralytics, timm and open_clip."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.kernels import runs_one_kernel
from ovman.perception import networks, weights
from ovman.perception.graph import Graph
from ovman.settings.config import load
from ovman.shipped import HOME
from tests.perception.refused import line

MODELS = HOME / "models"
CONFIG = load(HOME / "config.yaml")
BITS = {"detector": "8ca485fb7f78733b", "encoder": "9191163a11c5d196", "encoder.text": "bdeafaa797f3acd8"}
"""Digests of outputs, of ONNX Runtime 1.28; another release may sum otherwise."""


def sha256(name: str) -> str:
    return hashlib.sha256((MODELS / name).read_bytes()).hexdigest()


def test_graphs_are_of_the_weights_beside_them():
    assert (
        CONFIG.perception.detector.weights == "models/detector.onnx"
        and CONFIG.perception.encoder.weights == "models/encoder.onnx"
    )
    for kind in ("detector", "encoder"):
        found = Graph((MODELS / f"{kind}.onnx").read_bytes()).description
        assert (found.kind, found.source) == (kind, sha256(f"{kind}.safetensors"))
        assert {"torch", "onnx"} < found.made.keys()
    assert Graph((MODELS / "encoder.onnx").read_bytes()).description.facts["texts"] == sha256("encoder.text.onnx")
    readme = (MODELS / "README.md").read_text()
    for name in ("detector.onnx", "encoder.onnx", "encoder.text.onnx"):
        assert sha256(name) in readme


@pytest.mark.skipif(not runs_one_kernel(), reason="other sums are those of other instructions")
def test_the_networks_give_the_same_bits_on_every_processor_with_avx2():
    """The digests were met on a processor with AVX2 and, emulated, on one with AVX-512."""
    found = {}
    for kind, side in (("detector", 128), ("encoder", 96), ("encoder.text", 0)):
        pattern = np.arange(3 * side * side, dtype=np.int64) ** 2 % 251
        picture = (pattern.reshape(1, 3, side, side) / 256).astype(np.float32)
        given = picture if side else np.array([[101, 1037, 3242, 102]])  # "a chair"
        outputs = Graph((MODELS / f"{kind}.onnx").read_bytes())(given)
        found[kind] = hashlib.sha256(b"".join(one.tobytes() for one in outputs)).hexdigest()[:16]
    assert found == BITS


LOOKS = """
import sys
absent = sys.argv[2:]
sys.modules.update(dict.fromkeys(absent))
from pathlib import Path
import numpy as np
from ovman.settings.config import load
settings = load(Path(sys.argv[1]))
import ovman.remote.host
from ovman.evaluation import predictions, rollouts
from ovman.remote.perception import PerceptionPipeline
arm = next(arm for arm in settings.arms.values() if "networks" in arm.needs)
detector, encoder = PerceptionPipeline(settings, arm).networks()
for side_px in (settings.perception.detector.side_px, settings.locobot.side_px):
    detector.at(side_px).detect([np.zeros((300, 300, 3), np.uint8)])
encoder.images(np.zeros((1, encoder.side_px, encoder.side_px, 3), np.uint8)), encoder.texts(["chair", "a photo of a chair"])
print([name for name in absent if sys.modules[name] is not None])
"""


def test_a_job_that_looks_imports_no_network_library(tmp_path):
    """Nor is one needed: they are not even there."""
    command = [sys.executable, "-c", LOOKS, str(HOME / "config.yaml"), *weights.EXTRA, "timm", "statsmodels"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=HOME)
    assert (done.returncode, done.stdout.strip()) == (0, "[]"), done.stderr


@pytest.fixture
def settings(tmp_path) -> SimpleNamespace:
    """Those of the default, with files of its own."""
    for name in ("detector.onnx", "encoder.onnx", "encoder.text.onnx"):
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
    assert f"{kind}.onnx cannot be run: " in line(lambda: make(settings)) and "training.export" in line(lambda: make(settings))
    path.write_bytes((MODELS / f"{other}.onnx").read_bytes())
    assert f"is the graph of the {other}; name that of the {kind}" in line(lambda: make(settings))
    path.unlink()
    assert "is missing" in line(lambda: make(settings))
    path.write_bytes(whole)
    settings.device = "cuda"
    assert "runs on a processor" in line(lambda: make(settings)) and "set it to cpu" in line(lambda: make(settings))


def test_any_phrase_has_an_embedding_that_depends_on_it_alone(settings):
    read = networks.encoder_of(settings).texts
    assert read([]).shape == (0, 128)
    several = read(["chair", "a zeppelin", "", "Größe"])
    assert several.shape == (4, 128) and np.allclose(np.linalg.norm(several, axis=1), 1, atol=1e-6)
    assert np.array_equal(read(["a zeppelin"])[0], several[1])


@pytest.mark.parametrize("what", ["missing", "torn"])
def test_a_text_tower_of_somebody_else_is_one_line(settings, what):
    tower = settings.folder / "encoder.text.onnx"
    if what == "missing":
        tower.unlink()
    else:
        tower.write_bytes(tower.read_bytes()[:-10])
    said = line(lambda: networks.encoder_of(settings))
    assert {"missing": "encoder.text.onnx, the text tower", "torn": "is not the text tower of"}[what] in said


def test_who_looks_is_told_by_both_towers(settings):
    before = networks.looked_at_by(settings)
    assert json.loads(json.dumps(before)) == before and not {"torch", "ultralytics", "onnx"} & before["libraries"].keys()
    named = settings.detector.model_copy(update={"architecture": "yolov8m-seg"})
    assert networks.looked_at_by(SimpleNamespace(**vars(settings) | {"detector": named})) == before
    with (settings.folder / "encoder.text.onnx").open("ab") as file:
        file.write(b"more")
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
        remedy = "needs torch, ultralytics; in a checkout of OVMAN: pip install '.[networks]'"
        assert f"perception.{kind}.weights" in said and remedy in said
