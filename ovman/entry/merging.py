"""`ovman merge`: join shards of one evaluation into the folder that one evaluation of all their episodes would have left."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.atomic import replacing
from ovman.entry import EntryError
from ovman.entry.evaluation import ATTEMPTS, FINISHED
from ovman.entry.manifest import FILE, Manifest, Repeated, read_manifest
from ovman.entry.release import Release
from ovman.entry.summary import Summary, write_results
from ovman.entry.verification import At, Recorded, read_recorded
from ovman.records.run import Score

OWN = frozenset({"asked", "seeds", "machines", "repeated"})
"""Keys of a manifest in which shards of one evaluation may differ."""
SHOWN = 80
"""Characters of a value in a message."""


@dataclass(frozen=True, slots=True)
class Shard:
    """An evaluation of some of the episodes, in the folder `directory`."""

    directory: Path
    manifest: Manifest
    recorded: Recorded


def merge(out: Path, directories: Sequence[Path], release: Release, episodes_file: Path | None) -> tuple[Manifest, Summary]:
    """Merge evaluations into the folder `out`: manifest, runs, summary, finished runs and attempts.

    episodes_file: Episodes of the runs, if they are not of a released split.

    Raises:
        EntryError: The shards are of different evaluations, their runs differ, or a run is missing under a seed that others have.
    """
    is_among = any(one.exists() and out.exists() and out.samefile(one) for one in directories)
    if out.exists() and not is_among and (not out.is_dir() or any(out.iterdir())):
        raise EntryError(f"{out}: is there already; name another folder, or name it among those that are merged")
    shards = [_read_shard(directory, release, episodes_file) for directory in directories]
    first = shards[0]
    for shard in shards[1:]:
        _check_same_evaluation(first, shard)
    episodes = {name: episode for shard in shards for name, episode in shard.recorded.episodes.items()}
    order = [name for name in first.recorded.known if name in episodes]
    seeds = tuple(dict.fromkeys(seed for shard in shards for seed in shard.manifest.seeds))
    runs = _join_runs(shards)
    for name in order:
        for seed in seeds:
            if (name, seed) not in runs:
                raise EntryError(
                    f"{first.directory}: {name} is in a folder, and seed {seed} in none with it; run it under seed {seed}, too"
                )
    machines = tuple(dict.fromkeys(one for shard in shards for one in shard.manifest.machines))
    joined = {"asked": tuple(order), "seeds": seeds, "machines": machines, "repeated": _join_repeated(shards, seeds, order)}
    manifest = first.manifest.model_copy(update=joined)
    with replacing(out, FILE) as partial:
        partial.mkdir()
        (partial / FILE).write_text(manifest.to_line(), encoding="utf-8")
        for shard in shards:
            if (shard.directory / FINISHED).is_dir():
                shutil.copytree(shard.directory / FINISHED, partial / FINISHED, dirs_exist_ok=True)
        attempts = [path for shard in shards if (path := shard.directory / ATTEMPTS).is_file()]
        if attempts:
            lines = dict.fromkeys(line + b"\n" for path in attempts for line in path.read_bytes().splitlines() if line)
            (partial / ATTEMPTS).write_bytes(b"".join(lines))
        by_seed = [runs[name, seed] for seed in seeds for name in order]
        return manifest, write_results(partial, by_seed, [episodes[name] for name in order], manifest, release)


def _read_shard(directory: Path, release: Release, episodes_file: Path | None) -> Shard:
    """Return the evaluation in a folder. EntryError if it is not finished or something is wrong with it."""
    manifest = read_manifest(directory)
    recorded = read_recorded(directory, manifest, release, episodes_file)
    if recorded.faults:
        raise EntryError(f"{recorded.faults[0]}; run `ovman eval` with this folder to its end first")
    return Shard(directory, manifest, recorded)


def _join_runs(shards: Sequence[Shard]) -> dict[At, Score]:
    """Return the runs of all shards. EntryError for a run that differs between two of them."""
    runs: dict[At, Score] = {}
    for shard in shards:
        for at, (_, run) in shard.recorded.replayable.items():
            known = runs.setdefault(at, run)
            key = next((key for key in type(run).model_fields if getattr(known, key) != getattr(run, key)), None)
            if key is not None:
                says = f"{at[0]}, seed {at[1]}: {key}: {getattr(run, key)}, another folder has {getattr(known, key)}"
                raise EntryError(f"{shard.directory}: {says}; run one of the two again, or leave one out")
    return runs


def _join_repeated(shards: Sequence[Shard], seeds: Sequence[int], order: Sequence[str]) -> tuple[Repeated, ...]:
    """Return the runs that took several attempts in a shard, in the order of the runs."""
    most: dict[At, Repeated] = {}
    for one in (one for shard in shards for one in shard.manifest.repeated):
        most[one.episode, one.seed] = max(one, most.get((one.episode, one.seed), one), key=lambda run: run.attempts)
    return tuple(most[name, seed] for seed in seeds for name in order if (name, seed) in most)


def _check_same_evaluation(first: Shard, other: Shard) -> None:
    one, two = first.manifest.to_json(), other.manifest.to_json()
    for key in dict.fromkeys([*one, *two]):
        if key not in OWN and one.get(key) != two.get(key):
            says = f"{key}: {_shorten(two.get(key))}, {first.directory} has {_shorten(one.get(key))}"
            raise EntryError(f"{other.directory}: {says}; merge what one agent and one version made of one file of episodes")


def _shorten(value: Any) -> str:
    text = str(value)
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
