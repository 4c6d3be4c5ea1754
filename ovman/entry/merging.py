"""`ovman merge`: shards of one evaluation as one run of all their episodes would have left them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.atomic import replacing
from ovman.entry import attempts
from ovman.entry.errors import EntryError
from ovman.entry.evaluation import JOURNAL
from ovman.entry.manifest import FILE, Manifest, Repeated, read_manifest
from ovman.entry.recorded import At, Recorded, read_recorded
from ovman.entry.release import Release
from ovman.entry.results import write_results
from ovman.entry.summary import Summary
from ovman.records.run import Rollout, Score
from ovman.workflow.journal import contents

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

    @property
    def runs(self) -> dict[At, Score]:
        """Its runs by episode and seed."""
        return {at: run for at, (_, run) in self.recorded.drivable.items()}


def merge(out: Path, directories: Sequence[Path], release: Release, episodes_file: Path | None) -> tuple[Manifest, Summary]:
    """Merge evaluations into the folder `out`: manifest, runs and summary, and the journals where each shard has one.

    episodes_file: that the runs are of, where they are of no released split. EntryError or RecordError, in one line with folder,
    key, both values and remedy: for shards of different evaluations, runs that differ, and runs that are in no shard though their
    episode and their seed are in some.
    """
    if out.exists() and not _among(out, directories) and (not out.is_dir() or any(out.iterdir())):
        raise EntryError(f"{out}: is there already; name another folder, or name it among those that are merged")
    shards = [_shard(directory, release, episodes_file) for directory in directories]
    first = shards[0]
    for shard in shards[1:]:
        _same_evaluation(first, shard)
    episodes = {name: episode for shard in shards for name, episode in shard.recorded.episodes.items()}
    order = [name for name in first.recorded.known if name in episodes]
    seeds = tuple(dict.fromkeys(seed for shard in shards for seed in shard.manifest.seeds))
    runs: dict[At, Score] = {}
    for shard in shards:
        for at, run in shard.runs.items():
            if at in runs and (key := _differing(runs[at], run)):
                says = f"{at[0]}, seed {at[1]}: {key}: {getattr(run, key)}, another folder has {getattr(runs[at], key)}"
                raise EntryError(f"{shard.directory}: {says}; run one of the two again, or leave one out")
            runs.setdefault(at, run)
    for name in order:
        for seed in seeds:
            if (name, seed) not in runs:
                raise EntryError(
                    f"{first.directory}: {name} is in a folder, and seed {seed} in none with it; run it under seed {seed}, too"
                )
    manifest = first.manifest.model_copy(
        update={
            "asked": tuple(order),
            "seeds": seeds,
            "machines": tuple(dict.fromkeys(one for shard in shards for one in shard.manifest.machines)),
            "repeated": _repeated(shards, seeds, order),
        }
    )
    journal = _journal(shards, [runs[name, seed] for name in order for seed in seeds])
    by_seed = [runs[name, seed] for seed in seeds for name in order]
    with replacing(out, FILE) as partial:
        partial.mkdir()
        (partial / FILE).write_text(manifest.to_line(), encoding="utf-8")
        if journal is not None:
            (partial / JOURNAL).write_bytes(journal)
        if begun := attempts.joined(shard.directory for shard in shards):
            (partial / attempts.FILE).write_bytes(begun)
        return manifest, write_results(partial, by_seed, [episodes[name] for name in order], manifest, release)


def _shard(directory: Path, release: Release, episodes_file: Path | None) -> Shard:
    """The evaluation in a folder. EntryError where it is not finished or something is wrong with it."""
    manifest = read_manifest(directory)
    recorded = read_recorded(directory, manifest, release, episodes_file)
    if recorded.faults:
        raise EntryError(f"{recorded.faults[0]}; run `ovman eval` with this folder to its end first")
    return Shard(directory, manifest, recorded)


def _repeated(shards: Sequence[Shard], seeds: Sequence[int], order: Sequence[str]) -> tuple[Repeated, ...]:
    """Runs that took several attempts in a shard, in the order of the runs."""
    most: dict[At, Repeated] = {}
    for one in (one for shard in shards for one in shard.manifest.repeated):
        most[one.episode, one.seed] = max(one, most.get((one.episode, one.seed), one), key=lambda run: run.attempts)
    return tuple(most[name, seed] for seed in seeds for name in order if (name, seed) in most)


def _among(out: Path, directories: Sequence[Path]) -> bool:
    return any(one.exists() and out.samefile(one) for one in directories)


def _same_evaluation(first: Shard, other: Shard) -> None:
    one, two = first.manifest.to_json(), other.manifest.to_json()
    for key in dict.fromkeys([*one, *two]):
        if key not in OWN and one.get(key) != two.get(key):
            says = f"{key}: {_shown(two.get(key))}, {first.directory} has {_shown(one.get(key))}"
            raise EntryError(f"{other.directory}: {says}; merge what one agent and one version made of one file of episodes")


def _differing(one: Score, other: Score) -> str | None:
    """The first key in which two runs differ."""
    return next((key for key in type(one).model_fields if getattr(one, key) != getattr(other, key)), None)


def _journal(shards: Sequence[Shard], runs: Sequence[Score]) -> bytes | None:
    """The journal of one evaluation of these runs, in their order; None where the shards' journals do not have them all.

    Lines of other runs, which an evaluation keeps of earlier code of its agent, are left out.
    """
    lines: dict[str, bytes] = {}
    for shard in shards:
        path = shard.directory / JOURNAL
        if not path.is_file():
            return None
        for line in contents(path).lines:
            lines.setdefault(Rollout.from_json(json.loads(line)["record"], str(path)).to_line(), line)
    wanted = [Rollout(**{name: getattr(run, name) for name in Rollout.model_fields}).to_line() for run in runs]
    return b"".join(lines[line] + b"\n" for line in wanted) if all(line in lines for line in wanted) else None


def _shown(value: Any) -> str:
    text = str(value)
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
