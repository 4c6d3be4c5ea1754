"""`ovman export`: the networks of a configuration as graphs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from ovman.export.graphs import write_detector, write_encoder
from ovman.perception.weights import GRAPH, SAFE, beside, detector_file, encoder_file, is_graph, sha256
from ovman.settings.config import load_files


def run(options: argparse.Namespace, say: Callable[[str], None]) -> None:
    """Write detector.onnx, encoder.onnx and encoder.phrases.npz into a folder.

    Of weights that are a graph already, the .safetensors file of the same name is exported. Raises WeightsError.
    """
    perception = load_files([options.config, *options.configfile]).perception
    out = Path(options.out)
    further = Path(options.phrases).read_text(encoding="utf-8").splitlines() if options.phrases else []
    trusted, finds, names = perception.trust_pickles, perception.detector, perception.encoder
    files = {name: out / f"{name}{GRAPH}" for name in ("detector", "encoder")}
    files["phrases"] = beside(files["encoder"])
    source = detector_file(_source(finds.weights), trusted)
    write_detector(source, finds.architecture, files["detector"], trusted)
    source, tag = encoder_file(names.model, _source(names.weights), trusted), names.weights
    phrases = [line.strip() for line in further if line.strip()]
    count = write_encoder(source, names.model, files["encoder"], files["phrases"], tag, phrases, trusted)
    for file in files.values():
        say(f"{file}  {file.stat().st_size:,} bytes  SHA-256 {sha256(file)}")
    say(f"{count} phrases; name them in config.yaml: perception.detector.weights and perception.encoder.weights")


def _source(weights: str) -> str:
    return weights.removesuffix(GRAPH) + SAFE if is_graph(weights) else weights
