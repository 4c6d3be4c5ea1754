"""Stage `models`: gathers the results of the trainings under the names of config.yaml and of the model cards."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from ovman.perception.weights import GRAPH, SAFE, beside
from ovman.training.crops import Crops
from ovman.training.encoder import MODEL
from ovman.training.floorplans import floor_plans
from ovman.training.picture_files import recorded
from ovman.workflow.parameter import StageSettings

LIBRARIES = ("torch", "ultralytics", "open_clip_torch")


def run(
    files: Mapping[str, Path], pictures: Sequence[Path], crops: Sequence[Path], constants: StageSettings, output: Path
) -> None:
    """Write the folder `output`: detector and encoder as .safetensors and as .onnx, encoder.phrases.npz, encoder.json (its
    architecture), the four curves and training.json with data, settings and libraries.

    files: "detector", "encoder" (weights), "detector_graph", "encoder_graph", "phrases", "detector_first_curve",
    "detector_curve", "encoder_true_curve", "encoder_curve".
    """
    output.mkdir(parents=True, exist_ok=True)
    for name in ("detector", "encoder"):
        shutil.copyfile(files[name], output / f"{name}{SAFE}")
        shutil.copyfile(files[f"{name}_graph"], output / f"{name}{GRAPH}")
    shutil.copyfile(files["phrases"], beside(output / f"encoder{GRAPH}"))
    for name in ("detector_first_curve", "detector_curve", "encoder_true_curve", "encoder_curve"):
        shutil.copyfile(files[name], output / f"{name}.jsonl")
    (output / "encoder.json").write_text(json.dumps(MODEL, indent=2) + "\n", encoding="utf-8")
    plans = floor_plans(constants.splits["main"].scenes)
    counts = {folder.name: len(recorded([folder])) for folder in pictures}
    shown: dict[str, int] = {}
    for path in crops:
        shown[path.parent.name] = shown.get(path.parent.name, 0) + len(Crops.read(path).types)
    facts = {
        "schema": "ovman-training/1",
        "floor_plans": {"taught": list(plans.taught), "held_out": list(plans.held_out)},
        "pictures": {name: sum(counts[scene] for scene in getattr(plans, name)) for name in ("taught", "held_out")},
        "crops": shown,
        "settings": json.loads(constants.canonical)["constants"],
        "libraries": {name: version(name) for name in LIBRARIES},
    }
    (output / "training.json").write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
