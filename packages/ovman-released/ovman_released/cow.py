"""Stage `released_cow`: CoW as its authors released it, on the released episodes, in a process and an environment of its own.

What is missing for it is no error: it is written down in one line, the records are empty, and the tables say so.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import ovman
import ovman_engine
import ovman_released
from ovman.records.episode import Episode
from ovman.records.note import Note
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings
from ovman_engine import COMMAND, executable
from ovman_released.clone import Clone
from ovman_released.cow_process import Job
from ovman_released.cow_results import collected
from ovman_released.interpreter import Needs, environment, lacks, linked
from ovman_released.plugin import COW
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
OF_PLACE = (f"{COW}.root", f"{COW}.python")
"""Constants that say where things are, not what they do."""


def missing(constants: StageSettings, needs: Needs = NEEDS) -> str | None:
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


def call(share: Sequence[Episode], seed: int, constants: StageSettings, directory: Path) -> subprocess.Popen[bytes]:
    """The released runner at work on `share` in a process of its own, which ends with this one."""
    settings = released_cow(constants)
    root = Path(settings.root).absolute()
    job = Job(root, directory / "results", directory / "verdicts.jsonl", constants.canonical, seed, tuple(share))
    job.write(directory / "job.json")
    command = [settings.python, "-m", "ovman_released.cow_process", str(directory / "job.json")]
    packages = linked(directory / "packages", ovman, ovman_engine, ovman_released)
    return subprocess.Popen(command, stdin=subprocess.PIPE, env=environment(packages) | {COMMAND: executable()})


def unit(share: Sequence[Episode], seed: int, constants: StageSettings) -> str:
    """Key of a call in the journal: all that it depends on, wherever the clone lies."""
    stage = json.loads(constants.canonical)
    stage["constants"] = {name: value for name, value in stage["constants"].items() if name not in OF_PLACE}
    return digest([episode.to_json() for episode in share], seed, stage)


def passed(episodes: Sequence[Episode], seed: int, constants: StageSettings, kept: Journal) -> list[Rollout]:
    """The rollouts of one seed, in the order of the episodes.

    The released agent carries state from one episode to the next, so a call of the runner is done whole or not at all.
    RuntimeError in one line where the runner fails.
    """
    parts = shares(episodes, released_cow(constants).processes)
    keys = [unit(part, seed, constants) for part in parts]
    with tempfile.TemporaryDirectory() as folder:
        working = {}
        for k, (key, part) in enumerate(zip(keys, parts, strict=True)):
            if key not in kept:
                directory = Path(folder, str(k))
                directory.mkdir()
                working[k] = call(part, seed, constants, directory), directory
        try:
            for k, (process, directory) in working.items():
                if status := process.wait():
                    raise RuntimeError(f"{SYSTEM}, seed {seed}: the runner ended with status {status}; the log has what it said")
                rollouts = collected(directory / "results", directory / "verdicts.jsonl", parts[k], seed)
                kept.write(keys[k], [rollout.to_json() for rollout in rollouts])
        finally:
            for process, _ in working.values():
                process.kill()
                process.wait()
    return [Rollout.from_json(record, str(kept.path)) for key in keys for record in kept[key]]


def run(
    episodes_file: Path,
    constants: StageSettings,
    outputs: Mapping[tuple[int, str], Path],
    note: Path,
    journal: Path,
) -> None:
    """Write the runs of every (seed, scene) of `outputs`, and to `note` whether there are any.

    A file has the rollouts of all episodes of a scene; it is empty where something is missing.
    """
    episodes = Episode.load(episodes_file)
    wrong = missing(constants)
    rollouts: dict[int, list[Rollout]] = {}
    if wrong is None:
        kept = Journal(journal)
        for seed in dict.fromkeys(seed for seed, _ in outputs):
            rollouts[seed] = passed(episodes, seed, constants, kept)
    else:
        print(f"{SYSTEM} is not run: {wrong}", flush=True)
    scenes = {episode.id: episode.scene for episode in episodes}
    for (seed, scene), output in outputs.items():
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(lines(one for one in rollouts.get(seed, ()) if scenes[one.episode] == scene), encoding="utf-8")
    Note(system=SYSTEM, missing=wrong or "").write(note)
