"""The networks of the settings, with their weights, on their device."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import Any

from ovman.models.settings.networks import Perception
from ovman.perception import detector, encoder, graph, predictor, weights
from ovman.perception.detector import Detector
from ovman.perception.encoder import Encoder
from ovman.perception.network_cache import NetworkCache
from ovman.perception.weights import WeightsError, detector_file, encoder_file, located, sha256

LIBRARIES = (
    "torch",
    "torchvision",
    "onnx",
    "onnxruntime",
    "ultralytics",
    "open_clip_torch",
    "numpy",
    "opencv-python",
    "opencv-python-headless",
)
"""Distributions on whose versions the output of a network may depend."""


def detector_weights(perception: Perception) -> Path:
    """The file of the detector's weights. WeightsError, in one line, if it is not available."""
    settings = perception.detector
    return detector_file(settings.weights, perception.trust_pickles, settings.sha256)


def encoder_weights(perception: Perception) -> Path:
    """The file of the encoder's weights. WeightsError, in one line, if it is not available."""
    settings = perception.encoder
    return encoder_file(settings.model, settings.weights, perception.trust_pickles, settings.sha256)


def detector_of(perception: Perception, confidence: float | None = None) -> Detector:
    """The detector of the settings, with another confidence threshold if one is given. WeightsError if it is not available."""
    settings = perception.detector
    _prepare(perception.device)
    path = detector_weights(perception)
    return Detector(
        lambda: detector.network_of(path, settings.architecture, perception.trust_pickles),
        settings.side_px,
        settings.confidence if confidence is None else confidence,
        perception.device,
        _kept(perception.device, (detector, predictor), sha256(path), settings.architecture),
    )


def encoder_of(perception: Perception) -> Encoder:
    """The encoder of the settings. WeightsError, in one line, if it is not available."""
    settings = perception.encoder
    _prepare(perception.device)
    path = encoder_weights(perception)

    def load() -> tuple[Any, encoder.Architecture]:
        towers = encoder.architecture(settings.model, settings.weights)
        return encoder.network_of(path, towers, perception.trust_pickles), towers

    file = located(settings.model)
    described = [settings.model, settings.weights] if file is None or not file.is_file() else sha256(file)
    return Encoder(load, perception.device, _kept(perception.device, (encoder,), sha256(path), described))


def looked_at_by(perception: Perception) -> dict[str, Any]:
    """Cache key of the networks: everything that what they see in a frame can depend on. JSON-serialisable.

    It holds digests of the weights and of the encoder's configuration, the constants of the section `perception`, and the
    versions of the libraries; names of files do not count. WeightsError if weights are not available.
    """
    finds, names = perception.detector, perception.encoder
    towers = located(names.model)
    return {
        "weights": [sha256(detector_weights(perception)), sha256(encoder_weights(perception))],
        "detector": [finds.architecture, finds.side_px, finds.confidence, finds.min_mask_px],
        "encoder": [names.model if towers is None else sha256(towers), names.crop_padding],
        "device": perception.device,
        "libraries": _libraries(),
    }


def _prepare(device: str) -> None:
    """One thread and no autotuning, so that numbers do not depend on the load of the machine."""
    import cv2
    import torch

    torch.set_num_threads(1)
    torch.backends.cudnn.benchmark = False
    cv2.setNumThreads(1)
    if device == "cuda" and not torch.cuda.is_available():
        raise WeightsError("perception.device is cuda, but torch finds no GPU; set it to cpu")


def _kept(device: str, makers: Sequence[ModuleType], *of: Any) -> NetworkCache:
    """The cache of a network, keyed by its weights and architecture, the code and libraries that derive files from it, and the
    instruction set, which affects rounding. Nothing is cached for a GPU."""
    import torch

    if device != "cpu":
        return NetworkCache(None)
    code = [sha256(Path(str(module.__file__))) for module in (*makers, graph, weights)]
    depends_on = [of, code, _libraries(), torch.backends.cpu.get_cpu_capability()]
    return NetworkCache(hashlib.sha256(json.dumps(depends_on).encode()).hexdigest())


def _libraries() -> dict[str, str]:
    return {name: found for name in LIBRARIES if (found := _version(name)) is not None}


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
