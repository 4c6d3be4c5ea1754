"""The networks of the settings, on their device.

A graph (.onnx) runs on a processor, without PyTorch and with the same numbers on every processor. PyTorch runs all other weights,
on the processor or on a GPU; `python -m training.export` makes a graph of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cache as remember
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ovman.perception import detector, encoder, pytorch
from ovman.perception.detector import Detector, DetectorFacts
from ovman.perception.encoder import Encoder, EncoderFacts, Texts, unit
from ovman.perception.graph import Graph, GraphError
from ovman.perception.records import write_nouns
from ovman.perception.weights import (
    WeightsError,
    detector_file,
    encoder_file,
    is_graph,
    located,
    need_networks,
    sha256,
    texts_of,
)
from ovman.perception.wordpieces import WordPieces
from ovman.settings import Settings
from ovman.settings.networks import Perception

LIBRARIES = ("onnxruntime", "numpy", "opencv-python", "opencv-python-headless")
"""Distributions on whose versions the output of a graph may depend."""
TORCH_LIBRARIES = ("torch", "torchvision", "onnx", "ultralytics", "open_clip_torch")
"""Distributions on whose versions the output of PyTorch may depend."""
EXPORT, TRAINED = "make it with `python -m training.export`", "`make models` makes both"


def write_noun_embeddings(phrases: Sequence[str], settings: Settings, output: Path) -> None:
    """Write the unit embeddings of noun phrases, sorted, each once. Raises WeightsError."""
    distinct = sorted(set(phrases))
    features = encoder_of(settings.perception).texts(distinct)
    write_nouns(output, dict(zip(distinct, features, strict=True)))
    print(f"{len(distinct)} noun phrases", flush=True)


def detector_of(perception: Perception, confidence: float | None = None) -> Detector:
    """Return the detector of the settings, with another confidence threshold if one is given. Raises WeightsError."""
    cv2.setNumThreads(1)  # so that numbers do not depend on the load of the machine
    settings, path = perception.detector, detector_weights(perception)
    threshold = settings.confidence if confidence is None else confidence
    if is_graph(settings.weights):
        graph = _open_graph(path, settings.weights, "detector", perception.device)
        return Detector(graph, DetectorFacts(**graph.description.facts), settings.side_px, threshold)
    need_networks(settings.weights, detector.KEY)
    network = pytorch.load_detector(path, settings.architecture, perception.trust_pickles)
    return loaded_detector(network, settings.side_px, threshold, perception.device)


def loaded_detector(network: Any, side_px: int, confidence: float, device: str = "cpu") -> Detector:
    """Return the detector of a network of ultralytics, which PyTorch runs."""
    run = pytorch.run_by_torch(pytorch.fuse_detector(network), device)
    return Detector(run, pytorch.detector_facts(network), side_px, confidence)


def encoder_of(perception: Perception) -> Encoder:
    """Return the encoder of the settings. Raises WeightsError."""
    cv2.setNumThreads(1)
    settings, path, device = perception.encoder, encoder_weights(perception), perception.device
    if is_graph(settings.weights):
        graph = _open_graph(path, settings.weights, "encoder", device)
        facts = EncoderFacts(**graph.description.facts)
        texts = _texts_file(path, settings.weights)
        if sha256(texts) != facts.texts:
            raise WeightsError(f"{encoder.KEY}.weights: {texts.name} is not the text tower of {settings.weights}; {TRAINED}")
        return Encoder(graph, facts, text_tower(texts))
    need_networks(settings.weights, encoder.KEY)
    of = pytorch.read_architecture(settings.model, settings.weights)
    network = pytorch.load_towers(path, of, perception.trust_pickles).float().eval()
    tower = pytorch.run_by_torch(network.visual, device)
    network.to(device)
    return Encoder(tower, pytorch.towers_facts(network, of), lambda phrases: pytorch.embed_texts(network, of, phrases, device))


def text_tower(path: Path) -> Texts:
    """Return the text tower in a graph. It is opened at the first phrase, which most jobs never ask. Raises WeightsError then."""

    @remember
    def tower() -> tuple[Graph, WordPieces]:
        graph = _read_graph(path, path.name, "text", encoder.KEY)
        return graph, WordPieces(graph.description.facts["pieces"])

    def read(phrases: Sequence[str]) -> np.ndarray:
        graph, pieces = tower()
        return unit(np.concatenate([graph(pieces.numbers(phrase))[0] for phrase in phrases]))

    return read


def detector_weights(perception: Perception) -> Path:
    """Return the file of the detector's weights. Raises WeightsError if it is not available."""
    settings = perception.detector
    return detector_file(settings.weights, perception.trust_pickles, settings.sha256)


def encoder_weights(perception: Perception) -> Path:
    """Return the file of the encoder's weights. Raises WeightsError if it is not available."""
    settings = perception.encoder
    return encoder_file(settings.model, settings.weights, perception.trust_pickles, settings.sha256)


def looked_at_by(perception: Perception) -> dict[str, Any]:
    """Return the part of a cache's key that stands for the networks, JSON-serialisable. Raises WeightsError.

    It has digests of the weights and of the text tower, the constants of the section `perception`, and the versions of the
    libraries; names of files do not count.
    """
    finds, names = perception.detector, perception.encoder
    graphs = is_graph(finds.weights), is_graph(names.weights)
    described = _texts_file(encoder_weights(perception), names.weights) if graphs[1] else located(names.model)
    return {
        "weights": [sha256(detector_weights(perception)), sha256(encoder_weights(perception))],
        "detector": [None if graphs[0] else finds.architecture, finds.side_px, finds.confidence, finds.min_mask_px],
        "encoder": [names.model if described is None else sha256(described), names.crop_padding],
        "device": perception.device,
        "libraries": _versions(LIBRARIES if all(graphs) else (*LIBRARIES, *TORCH_LIBRARIES)),
    }


def _open_graph(path: Path, name: str, kind: str, device: str) -> Graph:
    key = f"perception.{kind}"
    if device != "cpu":
        raise WeightsError(
            f"{key}.weights is {name}, a graph, which runs on a processor, and perception.device is {device}; "
            f"set it to cpu, or name the weights that the graph was made of"
        )
    return _read_graph(path, name, kind, key)


def _read_graph(path: Path, name: str, kind: str, key: str) -> Graph:
    try:
        found = Graph(path.read_bytes())
    except GraphError as error:
        raise WeightsError(f"{key}.weights: {name} cannot be run: {error}; {EXPORT}") from None
    if found.description.kind != kind:
        raise WeightsError(f"{key}.weights: {name} is the graph of the {found.description.kind}; name that of the {kind}")
    return found


def _texts_file(path: Path, name: str) -> Path:
    found = texts_of(path)
    if not found.is_file():
        raise WeightsError(f"{encoder.KEY}.weights: {found.name}, the text tower of {name}, is missing; {TRAINED}")
    return found


def _versions(names: Sequence[str]) -> dict[str, str]:
    found = {}
    for name in names:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found
