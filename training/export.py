"""Export networks that ultralytics and open_clip load as graphs, with embeddings of phrases.

python -m training.export --out models
python -m training.export --out models --configfile OVERLAY --phrases FILE
"""

from __future__ import annotations

import argparse
import io
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.cow.localiser import prompt
from ovman.atomic import replace_bytes
from ovman.language.vocabulary import SYNONYMS, all_nouns
from ovman.perception import detector, pytorch
from ovman.perception.encoder import Phrases
from ovman.perception.graph import DESCRIPTION, PICTURES, Description
from ovman.perception.weights import GRAPH, SAFE, detector_file, encoder_file, is_graph, need_networks, phrases_of, sha256
from ovman.settings.config import load_files

OPSET = 17
SIDE_PX = 64
"""Side of the picture that a detector is shown while it is exported; its graph takes any multiple of its stride."""
DETECTOR_LIBRARIES = ("torch", "onnx", "ultralytics")
ENCODER_LIBRARIES = ("torch", "onnx", "open_clip_torch")
AXES = ("number", "channels", "height", "width")
"""Names of the axes of a graph's input."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Write detector.onnx, encoder.onnx and encoder.phrases.npz into a folder.

    Of weights that are a graph already, the .safetensors file of the same name is exported.

    Raises:
        WeightsError, ConfigError: In one line.
    """
    parser = argparse.ArgumentParser(prog="python -m training.export", description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", default="models", metavar="DIR", help="folder of the files; default: models")
    parser.add_argument("--phrases", metavar="FILE", help="further phrases, one per line")
    parser.add_argument("--configfile", nargs="+", default=[], metavar="OVERLAY", help="overlays that name other networks")
    options = parser.parse_args(arguments)
    perception = load_files(["config.yaml", *options.configfile]).perception
    finds, names, is_trusted = perception.detector, perception.encoder, perception.trust_pickles
    out = Path(options.out)
    files = [out / f"detector{GRAPH}", out / f"encoder{GRAPH}", phrases_of(out / f"encoder{GRAPH}")]
    weights = detector_file(_source(finds.weights), is_trusted)
    need_networks(weights.name, detector.KEY)
    write_detector(weights, finds.architecture, files[0], is_trusted)
    weights = encoder_file(names.model, _source(names.weights), is_trusted)
    added = Path(options.phrases).read_text(encoding="utf-8").splitlines() if options.phrases else []
    phrases = [line.strip() for line in added if line.strip()]
    count = write_encoder(weights, names.model, files[1], names.weights, phrases, is_trusted)
    for file in files:
        print(f"{file}  {file.stat().st_size:,} bytes  SHA-256 {sha256(file)}")
    print(f"{count} phrases; name them in config.yaml: perception.detector.weights and perception.encoder.weights")


def write_detector(weights: Path, architecture: str, output: Path, trust_pickles: bool = False) -> None:
    """Write the graph of a detector of ultralytics with the weights of a file. Raises WeightsError."""
    _use_one_thread()
    network = pytorch.load_detector(weights, architecture, trust_pickles)
    replace_bytes(output, detector_graph(network, weights))


def write_encoder(
    weights: Path, model: str, graph: Path, tag: str = "", added: Sequence[str] = (), trust_pickles: bool = False
) -> int:
    """Write the graph of an image tower of open_clip, and next to it the embeddings of phrases, with the weights of a file.

    Args:
        weights: The file of weights.
        model: open_clip's name of the towers, or a file of their configuration.
        graph: File of the graph.
        tag: Name of released weights, whose normalisation counts.
        added: Phrases in addition to those of the benchmark.
        trust_pickles: Whether a pickle may be opened.

    Returns:
        The number of phrases.

    Raises:
        WeightsError: The weights cannot be used.
    """
    _use_one_thread()
    of = pytorch.read_architecture(model, tag)
    network = pytorch.load_towers(weights, of, trust_pickles).float().eval()
    replace_bytes(graph, encoder_graph(network, of, weights))
    known, feature = embed_phrases(partial(pytorch.embed_texts, network, of), added)
    Phrases(known, feature, sha256(weights), _versions(ENCODER_LIBRARIES)).write(phrases_of(graph))
    return len(known)


def detector_graph(network: Any, weights: Path) -> bytes:
    """Return the graph of a detector of ultralytics for one picture of any size. weights: the file of its weights."""
    graph = export_graph(pytorch.fuse_detector(network), (1, 3, SIDE_PX, SIDE_PX), (2, 3))
    facts = asdict(pytorch.detector_facts(network))
    return describe_graph(graph, Description("detector", facts, sha256(weights), _versions(DETECTOR_LIBRARIES)))


def encoder_graph(network: Any, of: pytorch.Architecture, weights: Path) -> bytes:
    """Return the graph of an image tower for any number of crops. weights: the file of its weights."""
    facts = pytorch.towers_facts(network, of)
    graph = export_graph(network.float().eval().visual, (2, 3, facts.side_px, facts.side_px), (0,))
    return describe_graph(graph, Description("encoder", asdict(facts), sha256(weights), _versions(ENCODER_LIBRARIES)))


def describe_graph(graph: bytes, description: Description) -> bytes:
    """Return an ONNX file with a description among its metadata."""
    import onnx

    model = onnx.load_model_from_string(graph)
    onnx.helper.set_model_props(model, {DESCRIPTION: description.text()})
    return bytes(model.SerializeToString())


def export_graph(network: Any, shape: Sequence[int], free: Sequence[int]) -> bytes:
    """Return a torch module, on the processor and in evaluation mode, as an ONNX file.

    Args:
        network: The module.
        shape: (N, C, H, W) of the pictures that it is shown.
        free: The axes that may be of any size.
    """
    import torch

    file = io.BytesIO()
    to: Any = file  # torch writes to one, and its types do not say so
    fast = torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # an operation without an ONNX equivalent
    try:
        with torch.inference_mode(), warnings.catch_warnings(action="ignore"):
            torch.onnx.export(
                network,
                (torch.zeros(*shape),),
                to,
                dynamo=False,
                opset_version=OPSET,
                input_names=[PICTURES],
                dynamic_axes={PICTURES: {axis: AXES[axis] for axis in free}},
            )
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)
    return file.getvalue()


def embed_phrases(embed: Callable[[Sequence[str]], np.ndarray], added: Sequence[str] = ()) -> tuple[tuple[str, ...], np.ndarray]:
    """Return all phrases and their unit embeddings (N, K): the nouns of the vocabulary, CoW's prompts, and `added` ones.

    Nouns are embedded together, in alphabetical order, and all others one by one: the rest of a batch changes the last bits.
    """
    nouns = tuple(sorted(set(all_nouns())))
    prompts = [prompt(category) for category in (*SYNONYMS, "Floor")]
    others = tuple(phrase for phrase in dict.fromkeys([*prompts, *added]) if phrase not in nouns)
    return nouns + others, np.concatenate([embed(nouns), *(embed([phrase]) for phrase in others)])


def _versions(libraries: Sequence[str]) -> dict[str, str]:
    return {name: version(name) for name in libraries}


def _source(weights: str) -> str:
    return weights.removesuffix(GRAPH) + SAFE if is_graph(weights) else weights


def _use_one_thread() -> None:
    import torch

    torch.set_num_threads(1)


if __name__ == "__main__":
    try:
        main()
    except ValueError as error:
        sys.exit(f"training.export: {error}")
