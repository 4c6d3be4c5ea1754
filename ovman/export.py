"""Export networks that ultralytics and open_clip load as graphs, with embeddings of phrases: `ovman export`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ovman.agents.cow.localiser import prompt
from ovman.atomic import replace_bytes
from ovman.language.vocabulary import SYNONYMS, all_nouns
from ovman.perception import detector, encoder, exporting, towers, yolo
from ovman.perception.phrases import Phrases
from ovman.perception.weights import GRAPH, SAFE, detector_file, encoder_file, is_graph, need_networks, phrases_of, sha256
from ovman.settings.config import load_files


def run(options: argparse.Namespace, say: Callable[[str], None]) -> None:
    """Write detector.onnx, encoder.onnx and encoder.phrases.npz into a folder. Raises WeightsError.

    Of weights that are a graph already, the .safetensors file of the same name is exported.
    """
    perception = load_files([options.config, *options.configfile]).perception
    out = Path(options.out)
    added = Path(options.phrases).read_text(encoding="utf-8").splitlines() if options.phrases else []
    is_trusted, finds, names = perception.trust_pickles, perception.detector, perception.encoder
    files = [out / f"detector{GRAPH}", out / f"encoder{GRAPH}", phrases_of(out / f"encoder{GRAPH}")]
    write_detector(detector_file(_source(finds.weights), is_trusted), finds.architecture, files[0], is_trusted)
    source, phrases = (
        encoder_file(names.model, _source(names.weights), is_trusted),
        [line.strip() for line in added if line.strip()],
    )
    count = write_encoder(source, names.model, files[1], files[2], names.weights, phrases, is_trusted)
    for file in files:
        say(f"{file}  {file.stat().st_size:,} bytes  SHA-256 {sha256(file)}")
    say(f"{count} phrases; name them in config.yaml: perception.detector.weights and perception.encoder.weights")


def write_detector(weights: Path, architecture: str, output: Path, trust_pickles: bool = False) -> None:
    """Write the graph of a detector of ultralytics with the weights of a file. Raises WeightsError."""
    need_networks(weights.name, detector.KEY)
    _use_one_thread()
    network = yolo.network_of(weights, architecture, trust_pickles)
    replace_bytes(output, exporting.detector_graph(network, weights))


def write_encoder(
    weights: Path,
    model: str,
    graph: Path,
    phrases: Path,
    tag: str = "",
    added: Sequence[str] = (),
    trust_pickles: bool = False,
) -> int:
    """Write the graph of an image tower of open_clip and the embeddings of phrases with the weights of a file.

    Args:
        weights: The file of weights.
        model: open_clip's name of the towers, or a file of their configuration.
        graph: File of the graph.
        phrases: File of the embeddings.
        tag: Name of released weights, whose normalisation counts.
        added: Phrases in addition to those of the benchmark.
        trust_pickles: Whether a pickle may be opened.

    Returns:
        The number of phrases.

    Raises:
        WeightsError: The weights cannot be used.
    """
    need_networks(weights.name, encoder.KEY)
    _use_one_thread()
    of = towers.architecture(model, tag)
    network = towers.network_of(weights, of, trust_pickles).float().eval()
    replace_bytes(graph, exporting.encoder_graph(network, of, weights))
    known, feature = embed_phrases(partial(towers.texts, network, of), added)
    Phrases(known, feature, sha256(weights), exporting.made_by(exporting.ENCODER_LIBRARIES)).write(phrases)
    return len(known)


def embed_phrases(embed: Callable[[Sequence[str]], np.ndarray], added: Sequence[str] = ()) -> tuple[tuple[str, ...], np.ndarray]:
    """Return all phrases and their unit embeddings (N, K): the nouns of the vocabulary, CoW's prompts, and `added` ones.

    Nouns are embedded together, in alphabetical order, and all others one by one: the rest of a batch changes the last bits.
    """
    nouns = tuple(sorted(set(all_nouns())))
    prompts = [prompt(category) for category in (*SYNONYMS, "Floor")]
    others = tuple(phrase for phrase in dict.fromkeys([*prompts, *added]) if phrase not in nouns)
    return nouns + others, np.concatenate([embed(nouns), *(embed([phrase]) for phrase in others)])


def _source(weights: str) -> str:
    return weights.removesuffix(GRAPH) + SAFE if is_graph(weights) else weights


def _use_one_thread() -> None:
    import torch

    torch.set_num_threads(1)
