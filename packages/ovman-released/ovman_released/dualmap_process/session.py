"""One run of DualMap over one sequence, from its settings to the file of its objects."""

from __future__ import annotations

import importlib
import json
import random
import runpy
import shutil
import time
from pathlib import Path
from typing import Any

import numpy as np

from . import guard, objects

SAID = 50
"""Frames between two lines of the log."""


class RunError(Exception):
    """A run that cannot be made; one line that says what is missing and how to get it."""


def run(request: dict[str, Any]) -> None:
    """Makes one run and writes `objects.npz` and `run.json` into the directory "output" of the request.

    A request has "overrides" (of DualMap's settings, as on its command line), "guard" (first_only, every_frame), "nouns" (phrases
    whose text features are wanted), "seed" (of every generator, or None as released), "device" (cuda, cpu), "map" (where the
    objects are saved) and "before" (a Python file whose function `before` is called before DualMap is built, or None: networks
    that stand in for its own). The current directory is the clone. The list of classes is copied, as it is, since DualMap writes
    colours beside it.
    """
    began = time.monotonic()
    if request["before"] is not None:
        runpy.run_path(request["before"])["before"]()
    if request["seed"] is not None:
        _seed(request["seed"])
    output = Path(request["output"])
    settings = _settings(request["overrides"])
    settings.yolo.given_classes_path = str(shutil.copy(settings.yolo.given_classes_path, output / "classes.txt"))
    guard.apply(importlib.import_module("utils.object_detector"), request["guard"])
    system = importlib.import_module("dualmap.core").Dualmap(settings)
    try:
        # It is what the detector sets last; weights that did not load are only logged.
        if not hasattr(getattr(system, "detector", None), "filter"):
            raise RunError("the detector is not complete: weights did not load, the log says which; get them again")
        given, keyframes, sights = _walk(system, settings)
        before = len(system.local_map_manager.local_map)
        system.end_process()
        _see(system, sights)
        nouns = _text_features(system, request["nouns"], request["device"])
    finally:
        system.stop_thread = True
    names = Path(settings.yolo.given_classes_path).read_text().splitlines()
    found = objects.read(Path(request["map"]), names, sights)
    objects.write(output / "objects.npz", found, nouns)
    kinds = [record["kind"] for record in found]
    counts = {kind: kinds.count(kind) for kind in (objects.LOCAL, objects.ANCHOR, objects.RELATED)}
    report = {"frames": given, "keyframes": keyframes, "local_before_the_end": before, "saved": counts}
    report["seconds"] = round(time.monotonic() - began, 1)
    (output / "run.json").write_text(json.dumps(report) + "\n")
    print(json.dumps(report), flush=True)


def _seed(seed: int) -> None:
    random.seed(seed)
    np.random.seed(seed)
    importlib.import_module("torch").manual_seed(seed)


def _settings(overrides: list[str]) -> Any:
    hydra = importlib.import_module("hydra")
    with hydra.initialize_config_dir(str(Path.cwd() / "config"), version_base=None):
        return hydra.compose("runner_dataset", overrides=overrides)


def _walk(system: Any, settings: Any) -> tuple[int, int, dict[str, tuple[int, int]]]:
    """Shows DualMap the sequence. Frames given, keyframes among them, and when each object was seen."""
    data = importlib.import_module("utils.dataset").dataset_initialization(settings)
    kind = importlib.import_module("utils.types").DataInput
    process = system.parallel_process if settings.use_parallel else system.sequential_process
    keyframes = 0
    for number, seconds in enumerate(data.time_stamps):
        if number % SAID == 0:
            print(f"frame {number + 1} of {len(data.time_stamps)}")
        pose = np.asarray(data.poses[number])
        if not system.check_keyframe(seconds, pose):
            continue
        color, name = data.get_color(number)
        process(
            kind(
                idx=system.get_keyframe_idx(),
                time_stamp=seconds,
                color=color,
                depth=data.get_depth(number),
                color_name=name,
                intrinsics=data.get_intrinsics(number),
                pose=pose,
            )
        )
        keyframes += 1
    sights: dict[str, tuple[int, int]] = {}
    _see(system, sights)
    return len(data.time_stamps), keyframes, sights


def _see(system: Any, sights: dict[str, tuple[int, int]]) -> None:
    """Adds first and last keyframe of the objects in the local map; a saved object has no memory of them."""
    for held in list(system.local_map_manager.local_map):
        frames = [observation.idx for observation in list(held.observations)]
        if frames:
            first, last = sights.get(str(held.uid), (min(frames), max(frames)))
            sights[str(held.uid)] = min(first, *frames), max(last, *frames)


def _text_features(system: Any, phrases: list[str], device: str) -> dict[str, np.ndarray]:
    """What DualMap makes of each phrase when it is asked for it, as it stands, without a template: (K,)."""
    with guard.on(device, importlib.import_module("torch")):
        made = {phrase: system.convert_inquiry_to_feat(phrase) for phrase in phrases}
    plain = {k: v.detach().cpu().numpy() if hasattr(v, "detach") else v for k, v in made.items()}
    return {phrase: np.asarray(feature, np.float32).reshape(-1) for phrase, feature in plain.items()}
