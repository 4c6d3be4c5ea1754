"""The networks of the settings, on their device.

On a processor a network is a graph: the file that the settings name, or one that is made of the weights they name and kept in the
user's cache. On a GPU torch runs it. What stands around it is the same.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ovman.perception import detector, encoder, exporting, graph, halved, towers, weights, yolo
from ovman.perception.array_file import ArrayFileError
from ovman.perception.detector import Detector, DetectorFacts
from ovman.perception.encoder import Encoder, EncoderFacts
from ovman.perception.graph import Graph, GraphError, Network
from ovman.perception.network_cache import NetworkCache
from ovman.perception.phrases import Phrases, UnknownPhraseError
from ovman.perception.weights import (
    WeightsError,
    detector_file,
    encoder_file,
    is_graph,
    located,
    need_networks,
    phrases_of,
    sha256,
)
from ovman.settings.networks import Perception

LIBRARIES = ("onnxruntime", "numpy", "opencv-python", "opencv-python-headless")
"""Distributions on whose versions the output of a graph may depend."""
EXPORTING = ("torch", "torchvision", "onnx", "ultralytics", "open_clip_torch")
"""Distributions on whose versions a graph may depend that is made here, and what torch runs."""
EXPORT = "make it with `ovman export`"


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
    settings, device = perception.detector, perception.device
    _prepare()
    path = detector_weights(perception)
    if is_graph(settings.weights):
        _on_processor(device, settings.weights, detector.KEY)
        network = _opened(path.read_bytes(), settings.weights, "detector")
    else:
        network_of = cache(lambda: yolo.network_of(path, settings.architecture, perception.trust_pickles))
        load = _needing_networks(network_of, settings.weights, detector.KEY)
        if device != "cpu":
            return loaded_detector(load(), path, settings.side_px, _threshold(settings.confidence, confidence), device)
        kept = _kept((yolo,), sha256(path), settings.architecture)
        made = kept.content("detector.onnx", lambda: exporting.detector_graph(load(), path))
        network = _opened(made, settings.weights, "detector")
    facts = DetectorFacts(**network.description.facts)
    return Detector(network, facts, settings.side_px, _threshold(settings.confidence, confidence))


def loaded_detector(network: Any, weights: Path, side_px: int, confidence: float, device: str = "cpu") -> Detector:
    """The detector of a network of ultralytics. weights: the file of its weights. Nothing is kept in the user's cache."""
    if device != "cpu":
        return Detector(_on_gpu(yolo.running(network), device), yolo.facts_of(network), side_px, confidence)
    found = Graph(exporting.detector_graph(network, weights))
    return Detector(found, DetectorFacts(**found.description.facts), side_px, confidence)


def encoder_of(perception: Perception) -> Encoder:
    """The encoder of the settings. WeightsError, in one line, if it is not available."""
    settings, device = perception.encoder, perception.device
    _prepare()
    path = encoder_weights(perception)
    if is_graph(settings.weights):
        _on_processor(device, settings.weights, encoder.KEY)
        tower = _opened(path.read_bytes(), settings.weights, "encoder")
        read = _table(path, tower.description.source, settings.weights)
        return Encoder(tower, EncoderFacts(**tower.description.facts), read)

    def loaded() -> tuple[Any, towers.Architecture]:
        of = towers.architecture(settings.model, settings.weights)
        return towers.network_of(path, of, perception.trust_pickles).float().eval(), of

    load = _needing_networks(cache(loaded), settings.weights, encoder.KEY)
    if device != "cpu":
        network, of = load()
        found = _on_gpu(network.visual, device)
        network.to(device)
        return Encoder(found, towers.facts_of(network, of), lambda phrases: towers.texts(network, of, phrases, device))
    file = located(settings.model)
    described = [settings.model, settings.weights] if file is None or not file.is_file() else sha256(file)
    kept = _kept((towers,), sha256(path), described)

    def graph_of(loaded: tuple[Any, towers.Architecture]) -> bytes:
        return exporting.encoder_graph(*loaded, path)

    tower = _opened(kept.content("images.onnx", lambda: graph_of(load())), settings.weights, "encoder")
    return Encoder(tower, EncoderFacts(**tower.description.facts), partial(_read, load, kept))


def looked_at_by(perception: Perception) -> dict[str, Any]:
    """Cache key of the networks: everything that what they see in a frame can depend on. JSON-serialisable.

    It holds digests of the weights and of what reads phrases, the constants of the section `perception`, and the versions of the
    libraries; names of files do not count. WeightsError if weights are not available.
    """
    finds, names = perception.detector, perception.encoder
    graphs = is_graph(finds.weights), is_graph(names.weights)
    return {
        "weights": [sha256(detector_weights(perception)), sha256(encoder_weights(perception))],
        "detector": [None if graphs[0] else finds.architecture, finds.side_px, finds.confidence, finds.min_mask_px],
        "encoder": [_reads_by(perception), names.crop_padding],
        "device": perception.device,
        "libraries": _libraries(LIBRARIES if all(graphs) else (*LIBRARIES, *EXPORTING)),
    }


def _reads_by(perception: Perception) -> str:
    settings = perception.encoder
    described = located(settings.model)
    if is_graph(settings.weights):
        described = _table_file(encoder_weights(perception), settings.weights)
    return settings.model if described is None else sha256(described)


def _threshold(confidence: float, other: float | None) -> float:
    return confidence if other is None else other


def _prepare() -> None:
    """One thread, so that numbers do not depend on the load of the machine."""
    import cv2

    cv2.setNumThreads(1)


def _on_processor(device: str, name: str, key: str) -> None:
    if device != "cpu":
        raise WeightsError(
            f"{key}.weights is {name}, a graph, which runs on a processor, and perception.device is {device}; "
            f"set it to cpu, or name the weights that the graph was made of"
        )


def _opened(file: bytes, name: str, kind: str) -> Graph:
    """A graph of a kind. WeightsError for anything else."""
    key = f"perception.{kind}"
    try:
        found = Graph(file)
    except GraphError as error:
        raise WeightsError(f"{key}.weights: {name} cannot be run: {error}; {EXPORT}") from None
    if found.description.kind != kind:
        raise WeightsError(f"{key}.weights: {name} is the graph of the {found.description.kind}; name that of the {kind}")
    return found


def _table(path: Path, source: str, name: str) -> encoder.Texts:
    """Embeddings of phrases from the table beside a graph, which is read when it is first asked."""

    @cache
    def table() -> Phrases:
        try:
            found = Phrases.read(_table_file(path, name))
        except ArrayFileError as error:
            raise WeightsError(f"{encoder.KEY}.weights: {error}") from None
        if found.source != source:
            raise WeightsError(f"{encoder.KEY}.weights: {phrases_of(path).name} is of other weights than {name}; {EXPORT}")
        return found

    def read(phrases: Sequence[str]) -> np.ndarray:
        try:
            return table().rows(phrases)
        except UnknownPhraseError as error:
            raise WeightsError(
                f"{encoder.KEY}.weights: {phrases_of(path).name} has no embedding of {str(error)!r}; "
                f"add it with `ovman export --phrases FILE`, a phrase a line, or name weights whose text tower reads it"
            ) from None

    return read


def _table_file(path: Path, name: str) -> Path:
    found = phrases_of(path)
    if not found.is_file():
        raise WeightsError(f"{encoder.KEY}.weights: {found.name}, the embeddings of phrases of {name}, is missing; {EXPORT}")
    return found


def _read(load: Callable[[], tuple[Any, towers.Architecture]], kept: NetworkCache, phrases: Sequence[str]) -> np.ndarray:
    """Embeddings of phrases by a text tower, once for each list of phrases."""
    asked = hashlib.sha256(json.dumps(list(phrases)).encode()).hexdigest()
    found = kept.content(f"{asked}.phrases", lambda: towers.texts(*load(), phrases).tobytes())
    return np.frombuffer(found, np.float32).reshape(len(phrases), -1).copy()


def _needing_networks(load: Callable[[], Any], name: str, key: str) -> Callable[[], Any]:
    """`load` with one thread of torch, where the extra is installed; else it raises WeightsError."""

    def loaded() -> Any:
        need_networks(name, key)
        import torch

        torch.set_num_threads(1)
        return load()

    return loaded


def _on_gpu(network: Any, device: str) -> Network:
    """A network that torch runs; its numbers do not depend on what was run before."""
    import torch

    torch.backends.cudnn.benchmark = False
    if not torch.cuda.is_available():
        raise WeightsError("perception.device is cuda, but torch finds no GPU; set it to cpu")
    network = network.to(device).eval()

    def run(pictures: np.ndarray) -> tuple[np.ndarray, ...]:
        with torch.inference_mode():
            given = network(torch.from_numpy(pictures).to(device))
        return tuple(one.float().cpu().numpy() for one in (given if isinstance(given, tuple | list) else (given,)))

    return run


def _kept(makers: Sequence[ModuleType], *of: Any) -> NetworkCache:
    """The cache of a network, keyed by its weights and architecture, the code and libraries that derive files from it, and the
    instruction set, which affects rounding."""
    import cv2

    code = [sha256(Path(str(module.__file__))) for module in (*makers, exporting, graph, halved, weights)]
    depends_on = [of, code, _libraries((*LIBRARIES, *EXPORTING)), cv2.getCPUFeaturesLine()]
    return NetworkCache(hashlib.sha256(json.dumps(depends_on).encode()).hexdigest())


def _libraries(names: Sequence[str]) -> dict[str, str]:
    return {name: found for name in names if (found := _version(name)) is not None}


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
