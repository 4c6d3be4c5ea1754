"""Stage `graphs`: both networks as the benchmark runs them, made of the weights that were trained."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

from ovman.export.graphs import write_detector, write_encoder
from ovman.settings import Settings
from ovman.training.encoder import MODEL


def run(detector: Path, encoder: Path, constants: Settings, files: Mapping[str, Path]) -> None:
    """Write "detector", "encoder" (graphs) and "phrases" of `files`. detector, encoder: files of weights."""
    write_detector(detector, constants.perception.detector.architecture, files["detector"])
    with tempfile.TemporaryDirectory(prefix="ovman-") as folder:
        model = Path(folder) / "encoder.json"
        model.write_text(json.dumps(MODEL), encoding="utf-8")
        count = write_encoder(encoder, str(model), files["encoder"], files["phrases"])
    print(f"both graphs, and {count} phrases", flush=True)
