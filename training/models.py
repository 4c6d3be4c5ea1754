"""Gather the trained networks, and what they were trained on, under the names of config.yaml and of the model cards."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from ovman.perception.weights import GRAPH, SAFE
from ovman.settings import Settings
from training.crops import Crops
from training.export import write_detector
from training.floorplans import floor_plans
from training.pictures import list_pictures, read_pictures

LIBRARIES = ("torch", "ultralytics")
CALIBRATED_EVERY = 40
"""One in so many pictures of a floor plan counts for the ranges of the detector's values."""


def run(
    detector: Path,
    encoder: Path,
    texts: Path,
    curves: Sequence[Path],
    pictures: Sequence[Path],
    crops: Sequence[Path],
    benchmark: Sequence[str],
    settings: Settings,
    output: Path,
) -> None:
    """Write the folder `output`.

    It gets detector and encoder as .safetensors and as .onnx, the text tower, the learning curves, and training.json with data,
    settings and libraries.

    Args:
        detector: Weights of the detector.
        encoder: Weights of the image tower; their graph is next to them.
        texts: Graph of the text tower.
        curves: Learning curves of all trainings.
        pictures: Folders of the recorded scenes.
        crops: Files of the encoder's training data, in one folder per kind of mask.
        benchmark: Scenes of the benchmark.
        settings: Section `training` and the architecture of the detector.
        output: The folder.
    """
    output.mkdir(parents=True, exist_ok=True)
    for name, weights in (("detector", detector), ("encoder", encoder)):
        shutil.copyfile(weights, output / f"{name}{SAFE}")
    for name, graph in (("encoder", encoder.with_suffix(GRAPH)), ("encoder.text", texts)):
        shutil.copyfile(graph, output / f"{name}{GRAPH}")
    for curve in curves:
        shutil.copyfile(curve, output / f"{curve.stem}_curve.jsonl")
    plans = floor_plans(benchmark)
    taught = list_pictures([folder for folder in pictures if folder.name not in plans.held_out], CALIBRATED_EVERY)
    write_detector(detector, settings.perception.detector, output / f"detector{GRAPH}", shown=read_pictures(taught))
    counts = {folder.name: len(list_pictures([folder])) for folder in pictures}
    shown: Counter[str] = Counter()
    for path in crops:
        shown[path.parent.name] += len(Crops.read(path).types)
    facts = {
        "schema": "ovman-training/1",
        "floor_plans": {"taught": list(plans.taught), "held_out": list(plans.held_out)},
        "homes": {"taught": settings.training.homes, "held_out": settings.training.held_out_homes},
        "pictures": {name: sum(counts[scene] for scene in getattr(plans, name)) for name in ("taught", "held_out")},
        "crops": shown,
        "settings": settings.constants(),
        "libraries": {name: version(name) for name in LIBRARIES},
    }
    (output / "training.json").write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
