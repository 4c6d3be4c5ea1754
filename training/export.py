"""Export networks as graphs: a detector that ultralytics loads, and the towers of the default encoder.

python -m training.export --out models
python -m training.export --out models --configfile OVERLAY
"""

from __future__ import annotations

import argparse
import hashlib
import io
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ovman.atomic import replace_bytes
from ovman.perception import detector, pytorch
from ovman.perception.detector import Letterbox
from ovman.perception.encoder import EncoderFacts
from ovman.perception.graph import DESCRIPTION, PICTURES, PIECES, Description, Graph
from ovman.perception.weights import GRAPH, SAFE, detector_file, is_graph, need_networks, sha256
from ovman.perception.wordpieces import WordPieces
from ovman.settings.config import load_files
from ovman.settings.networks import DetectorNetwork
from training.captions import Senses
from training.crops import CONTRAST
from training.pictures import Picture
from training.public import read_public

OPSET = 17
SIDE_PX = 64
"""Side of the picture that a detector is shown while it is exported; its graph takes any multiple of its stride."""
BASIS_EVERY = 4
"""One in so many of WordNet's artefacts counts for the principal components of the text tower."""
EXACT = "dfl"
"""Part of the names of a detector's last convolutions, which weigh the borders of boxes and stay in single precision."""
TOGETHER = 16
"""Crops that are shown at once to measure ranges."""
DETECTOR_LIBRARIES = ("torch", "onnx", "onnxruntime", "ultralytics")
ENCODER_LIBRARIES = ("torch", "onnx", "onnxruntime", "timm")


def main(arguments: Sequence[str] | None = None) -> None:
    """Write detector.onnx into a folder.

    Of weights that are a graph already, the .safetensors file of the same name is exported.

    Raises:
        WeightsError, ConfigError: In one line.
    """
    parser = argparse.ArgumentParser(
        prog="python -m training.export", description="Export the detector of the settings as a graph."
    )
    parser.add_argument("--out", default="models", metavar="DIR", help="folder of the file; default: models")
    parser.add_argument("--configfile", nargs="+", default=[], metavar="OVERLAY", help="overlays that name another detector")
    options = parser.parse_args(arguments)
    perception = load_files(["config.yaml", *options.configfile]).perception
    finds, is_trusted = perception.detector, perception.trust_pickles
    file = Path(options.out) / f"detector{GRAPH}"
    weights = detector_file(_source(finds.weights), is_trusted)
    need_networks(weights.name, detector.KEY)
    write_detector(weights, finds, file, is_trusted)
    print(f"{file}  {file.stat().st_size:,} bytes  SHA-256 {sha256(file)}")
    print("name it in config.yaml: perception.detector.weights")


def write_detector(
    weights: Path, finds: DetectorNetwork, output: Path, trust_pickles: bool = False, shown: Iterable[Picture] = ()
) -> None:
    """Write the graph of a detector of ultralytics with the weights of a file. shown: as for `detector_graph`."""
    _use_one_thread()
    network = pytorch.load_detector(weights, finds.architecture, trust_pickles)
    replace_bytes(output, detector_graph(network, weights, finds.side_px, shown))


def write_texts(output: Path) -> None:
    """Write the graph of the text tower, made of published weights alone, in eight bits. Its facts have the word pieces."""
    import torch
    from onnxruntime.quantization import quantize_dynamic

    from training.towers import SIZE, build_text_tower

    _use_one_thread()
    tower, pieces = build_text_tower()
    split = WordPieces(pieces)
    words = Senses.read(read_public("senses").decode()).artefacts()[::BASIS_EVERY]
    with torch.inference_mode():
        tower.project(torch.cat([tower(torch.from_numpy(split.numbers(word))) for word in words]))
    graph = export_graph(tower, torch.from_numpy(split.numbers("a chair")), PIECES, {1: "length"})
    quantised = _quantise(graph, lambda *files: quantize_dynamic(*files, per_channel=True, reduce_range=True))
    facts = {"size": SIZE, "pieces": list(pieces)}
    source = hashlib.sha256(read_public("text")).hexdigest()
    replace_bytes(output, describe_graph(quantised, Description("text", facts, source, _versions(ENCODER_LIBRARIES))))


def write_encoder(weights: Path, texts: Path, shown: np.ndarray, output: Path) -> None:
    """Write the graph of the image tower.

    Args:
        weights: The file of `training.encoder`.
        texts: Graph of the text tower that they were trained with.
        shown: Crops (N, S, S, 3), on which the ranges of values are measured.
        output: File of the graph.
    """
    from training.towers import DEVIATION, MEAN, SIZE, load_image_tower

    facts = EncoderFacts(shown.shape[1], SIZE, MEAN, DEVIATION, CONTRAST, sha256(texts))
    description = Description("encoder", asdict(facts), sha256(weights), _versions(ENCODER_LIBRARIES))
    replace_bytes(output, describe_graph(tower_graph(load_image_tower(weights), shown), description))


def quantise_tower(tower: Any, shown: np.ndarray) -> Graph:
    """Return an image tower as it runs in the end. shown: as for `write_encoder`."""
    return Graph(describe_graph(tower_graph(tower, shown), Description("encoder", {}, "", {})))


def tower_graph(tower: Any, shown: np.ndarray) -> bytes:
    """Return the graph of an image tower for any number of crops, its convolutions in eight bits."""
    from training.towers import fix_padding, prepare

    _use_one_thread()
    graph = export_graph(fix_padding(tower, shown.shape[1]), prepare(shown[:2]), PICTURES, {0: "number"})
    parts = (prepare(shown[k : k + TOGETHER]).contiguous().numpy() for k in range(0, len(shown), TOGETHER))
    return quantise_graph(graph, parts, ["Conv", "Add", "Clip"])  # onnxruntime quantises Pad, but gives wrong edges


def detector_graph(network: Any, weights: Path, side_px: int, shown: Iterable[Picture] = ()) -> bytes:
    """Return the graph of a detector of ultralytics for one picture of any size.

    Args:
        network: The detector.
        weights: The file of its weights.
        side_px: Pictures are scaled to this side.
        shown: Pictures on which the ranges of values are measured. With them, convolutions are in eight bits.
    """
    import torch

    facts = pytorch.detector_facts(network)
    graph = export_graph(pytorch.fuse_detector(network), torch.zeros(1, 3, SIDE_PX, SIDE_PX), PICTURES, {2: "height", 3: "width"})
    frames = [Letterbox.of(p.rgb.shape[0], p.rgb.shape[1], side_px, facts.stride).frame_of(p.rgb) for p in shown]
    if frames:
        graph = quantise_graph(graph, frames, ["Conv"], without=EXACT)
    return describe_graph(graph, Description("detector", asdict(facts), sha256(weights), _versions(DETECTOR_LIBRARIES)))


def quantise_graph(graph: bytes, shown: Iterable[np.ndarray], operators: Sequence[str], without: str = "") -> bytes:
    """Return a graph with operators of these kinds in eight bits.

    Args:
        graph: An ONNX file.
        shown: What its input is given, to measure the ranges of values.
        operators: Kinds of operators by ONNX's names.
        without: Operators whose names contain this word stay as they are, if it is not empty.
    """
    import onnx
    from onnxruntime.quantization import CalibrationDataReader, QuantType, quantize_static

    class Shown(CalibrationDataReader):  # type: ignore[misc]
        def __init__(self) -> None:
            self._parts = iter(shown)

        def get_next(self) -> dict[str, np.ndarray] | None:
            part = next(self._parts, None)
            return None if part is None else {PICTURES: part}

    def quantise(given: Path, made: Path) -> None:
        names = [node.name for node in onnx.load(given).graph.node]
        quantize_static(
            given,
            made,
            Shown(),
            op_types_to_quantize=operators,
            nodes_to_exclude=[name for name in names if without and without in name],
            activation_type=QuantType.QUInt8,
            per_channel=True,
            # Weights of seven bits. With eight, sums of two products overflow on processors without VNNI: other numbers.
            reduce_range=True,
        )

    return _quantise(graph, quantise)


def describe_graph(graph: bytes, description: Description) -> bytes:
    """Return an ONNX file with a description among its metadata."""
    import onnx

    model = onnx.load_model_from_string(graph)
    onnx.helper.set_model_props(model, {DESCRIPTION: description.text()})
    return bytes(model.SerializeToString())


def export_graph(network: Any, shown: Any, name: str, free: Mapping[int, str]) -> bytes:
    """Return a torch module, on the processor and in evaluation mode, as an ONNX file.

    Args:
        network: The module.
        shown: The tensor that it is shown.
        name: Of its input.
        free: The names of the axes that may be of any size.
    """
    import torch

    file = io.BytesIO()
    to: Any = file  # torch writes to one, and its types do not say so
    with torch.inference_mode(), warnings.catch_warnings(action="ignore"):
        torch.onnx.export(
            network, (shown,), to, dynamo=False, opset_version=OPSET, input_names=[name], dynamic_axes={name: dict(free)}
        )
    return file.getvalue()


def _quantise(graph: bytes, quantise: Callable[[Path, Path], None]) -> bytes:
    """Return a graph after constants are folded and `quantise` has written one file to another."""
    from onnxruntime.quantization.shape_inference import quant_pre_process

    with tempfile.TemporaryDirectory() as folder:
        given, plain, made = (Path(folder) / f"{name}{GRAPH}" for name in ("given", "plain", "made"))
        given.write_bytes(graph)
        quant_pre_process(given, plain, skip_symbolic_shape=True)
        quantise(plain, made)
        return made.read_bytes()


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
