"""Both graphs and the embeddings of phrases as files."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ovman.atomic import replace_bytes
from ovman.export.phrases import embedded
from ovman.perception import detector, encoder, exporting, towers, yolo
from ovman.perception.phrases import Phrases
from ovman.perception.weights import need_networks, sha256


def write_detector(weights: Path, architecture: str, output: Path, trust_pickles: bool = False) -> None:
    """Write the graph of a detector of ultralytics with the weights of a file. WeightsError, in one line, where there is none."""
    need_networks(weights.name, detector.KEY)
    _one_thread()
    network = yolo.network_of(weights, architecture, trust_pickles)
    replace_bytes(output, exporting.detector_graph(network, weights))


def write_encoder(
    weights: Path,
    model: str,
    graph: Path,
    phrases: Path,
    tag: str = "",
    further: Sequence[str] = (),
    trust_pickles: bool = False,
) -> int:
    """Write the graph of an image tower of open_clip and the embeddings of phrases with the weights of a file; their number.

    model: open_clip's name, or a file of the towers' configuration; tag: names released weights; further: phrases beside those of
    the benchmark. WeightsError, in one line, where there is none.
    """
    need_networks(weights.name, encoder.KEY)
    _one_thread()
    of = towers.architecture(model, tag)
    network = towers.network_of(weights, of, trust_pickles).float().eval()
    replace_bytes(graph, exporting.encoder_graph(network, of, weights))
    known, feature = embedded(partial(towers.texts, network, of), further)
    Phrases(known, feature, sha256(weights), exporting.made_by(exporting.ENCODER_LIBRARIES)).write(phrases)
    return len(known)


def _one_thread() -> None:
    import torch

    torch.set_num_threads(1)
