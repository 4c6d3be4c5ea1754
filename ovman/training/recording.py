"""Stage `pictures`: records a scene's training pictures as files.

`{scene}/images/0000.png`, `{scene}/labels/0000.txt` (outlines, as ultralytics reads them), `{scene}/ids/0000.png` (16 bit; 0 is
nothing, k the k-th object of this picture) and `{scene}/objects.jsonl` (one line a picture).
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ovman.seeds import generator
from ovman.settings import Settings
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.images import write_png
from ovman.training.floorplans import floor_plans
from ovman.training.outlines import labels
from ovman.training.pictures import Picture, pictures


def run(scene: str, constants: Settings, output: Path) -> None:
    """Records the pictures of a scene into the directory `output`: training.views of them, or training.held_out_views."""
    training = constants.training
    taught = scene in floor_plans(constants.splits["main"].scenes).taught
    views = training.views if taught else training.held_out_views
    simulator = controller.start(constants.benchmark.backend, scene, Embodiment.of(constants))
    try:
        rng = generator(training.seed, "pictures", scene)
        count = write(output, pictures(simulator, scene, views, rng))
    finally:
        simulator.stop()
    print(f"{scene}: {count} pictures", flush=True)


def write(folder: Path, views: Iterable[Picture]) -> int:
    """Write pictures as they come and return their number. OSError if the disk is full."""
    for kind in ("images", "labels", "ids"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    count = 0
    with (folder / "objects.jsonl").open("w", encoding="utf-8") as objects:
        for count, picture in enumerate(views, start=1):
            name = f"{count - 1:04d}"
            write_png(folder / "images" / f"{name}.png", picture.rgb)
            write_png(folder / "ids" / f"{name}.png", (picture.ids + 1).astype(np.uint16))
            (folder / "labels" / f"{name}.txt").write_text("".join(f"{line}\n" for line in labels(picture.ids)))
            objects.write(json.dumps([asdict(shown) for shown in picture.objects], separators=(",", ":")) + "\n")
    return count
