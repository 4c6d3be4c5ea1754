"""The networks that the settings name, with their weights, on their device."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import Any

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
"""By their distributions: what the numbers that a network gives may depend on beside its weights."""


def detector_weights(perception: Any) -> Path:
    """The detector's file; `perception` is the section of config.yaml. WeightsError, in one line, where it cannot be had."""
    settings = perception.detector
    return detector_file(settings.weights, perception.trust_pickles, settings.sha256)


def encoder_weights(perception: Any) -> Path:
    """The encoder's file; `perception` is the section of config.yaml. WeightsError, in one line, where it cannot be had."""
    settings = perception.encoder
    return encoder_file(settings.model, settings.weights, perception.trust_pickles, settings.sha256)


def detector_of(perception: Any, confidence: float | None = None) -> Detector:
    """The detector of the section `perception` of config.yaml, or one that is as sure as its caller wants. WeightsError, in one
    line, where it cannot be had."""
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


def encoder_of(perception: Any) -> Encoder:
    """The encoder of the section `perception` of config.yaml. WeightsError, in one line, where it cannot be had."""
    settings = perception.encoder
    _prepare(perception.device)
    path = encoder_weights(perception)

    def load() -> tuple[Any, encoder.Architecture]:
        towers = encoder.architecture(settings.model, settings.weights)
        return encoder.network_of(path, towers, perception.trust_pickles), towers

    file = located(settings.model)
    described = [settings.model, settings.weights] if file is None or not file.is_file() else sha256(file)
    return Encoder(load, perception.device, _kept(perception.device, (encoder,), sha256(path), described))


def looked_at_by(perception: Any) -> dict[str, Any]:
    """What tells apart two pairs of networks that may see different things in the same frame: the bytes of their weights and of
    the encoder's configuration, every constant of the section `perception` that they use, and the libraries' versions.

    JSON-serialisable. Names of files do not count. WeightsError where weights cannot be had.
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
    """One thread, and no choices by trial: a job's numbers do not depend on what else the machine does."""
    import cv2
    import torch

    torch.set_num_threads(1)
    torch.backends.cudnn.benchmark = False
    cv2.setNumThreads(1)
    if device == "cuda" and not torch.cuda.is_available():
        raise WeightsError("perception.device is cuda, and there is no GPU that torch can use; set it to cpu")


def _kept(device: str, makers: Sequence[ModuleType], *of: Any) -> NetworkCache:
    """Where what is made of a network is kept: by its weights and form, by the code and the libraries that make it, and by the
    instructions of the processor, which round differently. On a GPU nothing is made."""
    import torch

    if device != "cpu":
        return NetworkCache(None)
    code = [sha256(Path(str(module.__file__))) for module in (*makers, graph, weights)]
    hangs_on = [of, code, _libraries(), torch.backends.cpu.get_cpu_capability()]
    return NetworkCache(hashlib.sha256(json.dumps(hangs_on).encode()).hexdigest())


def _libraries() -> dict[str, str]:
    return {name: found for name in LIBRARIES if (found := _version(name)) is not None}


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
