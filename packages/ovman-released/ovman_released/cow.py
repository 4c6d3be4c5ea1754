"""Stage `released_cow`: CoW as its authors released it, on the released episodes, in a process and an environment of its own.

What is missing for it is no error: it is written down in one line, the records are empty, and the tables say so.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import ovman
import ovman_engine
import ovman_released
from ovman.cache import Cache, digest
from ovman.records.episode import Episode
from ovman.records.note import Note
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.settings import Settings
from ovman_engine import COMMAND, executable
from ovman_released.clone import Clone
from ovman_released.cow_process import Job
from ovman_released.cow_results import collected
from ovman_released.interpreter import Needs, environment, lacks, linked
from ovman_released.plugin import COW, ReleasedCow
from ovman_released.settings import released_cow

SYSTEM = "CoW (released)"
REPOSITORY = "https://github.com/real-stanford/cow"
OWL = "google/owlvit-base-patch32"
_DOWNLOAD = (
    '-c "from transformers import OwlViTForObjectDetection as M, OwlViTProcessor as P; '
    f"[k.from_pretrained('{OWL}') for k in (M, P)]\""
)
NEEDS = Needs(
    modules={
        "numpy": "numpy",
        "ai2thor": "ai2thor==5.0.0",
        "torch": "torch",
        "torchvision": "torchvision",
        "transformers": "transformers",
        "scipy": "scipy",
        "sklearn": "scikit-learn",
        "networkx": "networkx",
        "trimesh": "trimesh",
        "matplotlib": "matplotlib",
        "threadpoolctl": "threadpoolctl",
        "ftfy": "ftfy",
        "regex": "regex",
        "packaging": "packaging",
        "yaml": "pyyaml",
        "pydantic": "pydantic",
    },
    versions={"ai2thor": "5.0.0"},
    cached={OWL: ((("config.json",), ("model.safetensors", "pytorch_model.bin"), ("preprocessor_config.json",)), _DOWNLOAD)},
)
OF_PLACE = {"root", "python"}
"""Constants that say where things are, not what they do."""


def missing(constants: Settings, needs: Needs = NEEDS) -> str | None:
    """What keeps the released system from being run, in one line with its remedy; None where nothing does."""
    settings = released_cow(constants)
    if not settings.root:
        return f"{COW}.root names no clone; packages/ovman-released/README.md says how to make one"
    root = Path(settings.root).absolute()
    wrong = Clone(REPOSITORY, root, settings.commit).lacks()
    return wrong or lacks(COW, settings.python, settings.device, needs, environment())


def shares(episodes: Sequence[Episode], processes: int) -> list[tuple[Episode, ...]]:
    """The episodes in as many runs of consecutive ones, of equal length but for one episode; fewer where there are fewer."""
    n = max(1, min(processes, len(episodes)))
    return [tuple(episodes[k * len(episodes) // n : (k + 1) * len(episodes) // n]) for k in range(n)]


def call(share: Sequence[Episode], seed: int, settings: ReleasedCow, directory: Path) -> subprocess.Popen[bytes]:
    """Start the released runner on `share` in a process of its own, which ends with this one."""
    root = Path(settings.root).absolute()
    job = Job(root, directory / "results", directory / "verdicts.jsonl", settings, seed, tuple(share))
    job.write(directory / "job.json")
    command = [settings.python, "-m", "ovman_released.cow_process", str(directory / "job.json")]
    packages = linked(directory / "packages", ovman, ovman_engine, ovman_released)
    return subprocess.Popen(command, stdin=subprocess.PIPE, env=environment(packages) | {COMMAND: executable()})


def call_key(share: Sequence[Episode], seed: int, settings: ReleasedCow) -> str:
    """Return the key of a call in the cache: all that it depends on, wherever the clone lies."""
    return digest([episode.to_json() for episode in share], seed, settings.model_dump(mode="json", exclude=OF_PLACE))


def run_seed(episodes: Sequence[Episode], seed: int, settings: ReleasedCow, cache: Cache) -> list[Rollout]:
    """Return the rollouts of one seed, in the order of the episodes.

    The released agent carries state from one episode to the next, so a call of the runner is done whole or not at all.
    RuntimeError in one line if the runner fails.
    """
    parts = shares(episodes, settings.processes)
    keys = [call_key(part, seed, settings) for part in parts]
    with tempfile.TemporaryDirectory() as folder:
        working = {}
        for k, (key, part) in enumerate(zip(keys, parts, strict=True)):
            if not cache.path(key).exists():
                directory = Path(folder, str(k))
                directory.mkdir()
                working[k] = call(part, seed, settings, directory), directory
        try:
            for k, (process, directory) in working.items():
                if status := process.wait():
                    raise RuntimeError(f"{SYSTEM}, seed {seed}: the runner ended with status {status}; the log has what it said")
                rollouts = collected(directory / "results", directory / "verdicts.jsonl", parts[k], seed)
                records = [rollout.to_json() for rollout in rollouts]
                cache.get_or_compute(keys[k], partial(list, records))
        finally:
            for process, _ in working.values():
                process.kill()
                process.wait()
    return [Rollout.from_json(record, str(cache.path(key))) for key in keys for record in cache.get_or_compute(key, list)]


def run(episodes_file: Path, settings: Settings, seeds: Sequence[int], output: Path, note: Path, cache: Cache) -> None:
    """Write the rollouts under all seeds, and to `note` whether there are any. The file is empty if something is missing."""
    episodes, wrong = Episode.load(episodes_file), missing(settings)
    rollouts: list[Rollout] = []
    if wrong is None:
        for seed in seeds:
            rollouts += run_seed(episodes, seed, released_cow(settings), cache)
    else:
        print(f"{SYSTEM} is not run: {wrong}", flush=True)
    output.write_text(lines(rollouts), encoding="utf-8")
    Note(system=SYSTEM, missing=wrong or "").write(note)
