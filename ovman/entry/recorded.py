"""An evaluation as its folder has it, and what is wrong with it before anything is driven."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman import __version__
from ovman.entry.differences import MISSING, flat
from ovman.entry.errors import EntryError
from ovman.entry.manifest import FILE, Manifest, installed, this_machine
from ovman.entry.release import Release
from ovman.entry.results import SUMMARY
from ovman.entry.run_files import read_runs, runs_path
from ovman.entry.score_page import LEADERBOARD
from ovman.entry.summary import as_json, summary_of
from ovman.records.episode import SCHEMA, Episode
from ovman.records.run import Score

At = tuple[str, int]
"""Episode and seed of a run."""
CLOSE = 1e-9
"""Relative: sums and quotients of the same runs may differ in their last bits between processors."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """The runs of an evaluation, each with its place "file:line", in the order of the file.

    known: ids of all episodes of their file. episodes: those that are asked for, by id, in the order of the file. drivable: the
    runs of these under the manifest's seeds that have a trace, by episode and seed. faults: a line for each thing that is wrong.
    """

    manifest: Manifest
    known: Sequence[str]
    episodes: Mapping[str, Episode]
    runs: Sequence[tuple[str, Score]]
    drivable: Mapping[At, tuple[str, Score]]
    faults: Sequence[str]

    @property
    def complete(self) -> bool:
        """Whether every episode that is asked for is there under every seed."""
        return len(self.drivable) == len(self.episodes) * len(self.manifest.seeds)


def read_recorded(directory: Path, manifest: Manifest, release: Release, episodes_file: Path | None) -> Recorded:
    """The evaluation in a folder. Where the episodes are others than those here, no run is drivable.

    EntryError or RecordError, in one line, for files that cannot be read, and where nothing says which episodes the runs are of.
    """
    place = directory / FILE
    if episodes_file is None and manifest.split is None:
        raise EntryError(f"{place}: split: the episodes are no released split; name their file with --episodes")
    source = release.episodes(manifest.split or "") if episodes_file is None else episodes_file
    try:
        found, content = Episode.load(source), source.read_bytes()
    except OSError as error:
        raise EntryError(f"{source}: {error.strerror}; name a file of episodes") from None
    faults = list(_of_manifest(place, manifest, found, hashlib.sha256(content).hexdigest(), source))
    asked = set(manifest.asked)
    episodes = {episode.id: episode for episode in found if episode.id in asked}
    file = runs_path(directory)
    runs = list(read_runs(file))
    drivable: dict[At, tuple[str, Score]] = {}
    for where, run in runs:
        if wrong := _wrong(run, manifest, episodes, drivable):
            faults.append(f"{where}: {run.episode}, seed {run.seed}: {wrong}")
        else:
            drivable[run.episode, run.seed] = where, run
    there = {(run.episode, run.seed) for _, run in runs}
    absent = [(name, seed) for seed in manifest.seeds for name in episodes if (name, seed) not in there]
    faults += [f"{file}: {name}, seed {seed}: {MISSING} recorded, a run is asked for by {FILE}" for name, seed in absent]
    if any(line.startswith(f"{place}: sha256: ") for line in faults):
        drivable = {}
    return Recorded(manifest, [episode.id for episode in found], episodes, runs, drivable, faults)


def stated(directory: Path, recorded: Recorded, release: Release) -> Iterator[str]:
    """A line for each value of summary.json that the recorded runs do not come to. Nothing where there is no such file."""
    path, manifest = directory / SUMMARY, recorded.manifest
    if not path.is_file():
        return
    try:
        there = dict(flat(json.loads(path.read_text(encoding="utf-8"))))
    except (ValueError, RecursionError):
        yield f"{path}: is no JSON; make it again"
        return
    if not recorded.complete or recorded.faults:
        yield f"{path}: the runs are not those of {FILE}, so they come to nothing"
        return
    runs = [recorded.drivable[name, seed][1] for seed in manifest.seeds for name in recorded.episodes]
    made = summary_of(runs, [*recorded.episodes.values()], manifest, release)
    here = dict(flat(json.loads(as_json(made))))
    for key in (key for key in dict.fromkeys([*there, *here]) if not key.startswith(LEADERBOARD)):
        one, other = there.get(key, MISSING), here.get(key, MISSING)
        if not _close(one, other):
            yield f"{path}: {key}: {one} recorded, the runs come to {other}"


def remarks(manifest: Manifest) -> Iterator[str]:
    """Lines on repeated runs, and on versions and machines that are others here. They decide nothing about the recorded runs."""
    if manifest.repeated:
        yield f"{FILE}: repeated: {len(manifest.repeated)} runs took several attempts; the leaderboard counts them as failures"
    for key, here in (("ovman", __version__), ("engine", installed("ovman-engine"))):
        if (there := getattr(manifest, key)) != here:
            yield f"{FILE}: {key}: made with {there}, verified with {here}"
    machine = this_machine()
    for one in manifest.machines:
        if one != machine:
            yield f"{FILE}: machines: made on {_named(one)}, verified on {_named(machine)}"


def _of_manifest(place: Path, manifest: Manifest, episodes: Sequence[Episode], sha256: str, source: Path) -> Iterator[str]:
    """What a manifest says of its episodes and is otherwise in their file."""
    for key, there, here in (
        ("sha256", manifest.sha256, sha256),
        ("n", manifest.n, len(episodes)),
        ("protocol", manifest.protocol, SCHEMA),
    ):
        if there != here:
            yield f"{place}: {key}: {there} recorded, {here} in {source}"
    order = {episode.id: number for number, episode in enumerate(episodes)}
    for name in manifest.asked:
        if name not in order:
            yield f"{place}: asked: {name} recorded, no such episode in {source}"
    known = [order[name] for name in manifest.asked if name in order]
    if known != sorted(set(known)):
        yield f"{place}: asked: episodes twice or in another order than in {source}"
    if not manifest.asked or not manifest.seeds:
        yield f"{place}: asks for no run"
    if len(set(manifest.seeds)) < len(manifest.seeds):
        yield f"{place}: seeds: {list(manifest.seeds)} recorded, a seed stands twice"


def _wrong(run: Score, manifest: Manifest, episodes: Mapping[str, Episode], there: Mapping[At, Any]) -> str | None:
    """What keeps a run from being one of an evaluation, None for nothing."""
    if run.arm != manifest.arm:
        return f"arm: {run.arm} recorded, {manifest.arm} in {FILE}"
    if run.episode not in episodes:
        return f"episode: recorded, not asked for by {FILE}"
    if run.seed not in manifest.seeds:
        return f"seed: recorded, not among {list(manifest.seeds)} of {FILE}"
    if (run.episode, run.seed) in there:
        return f"recorded in {there[run.episode, run.seed][0].rpartition(':')[2]}, too: one run is asked for"
    if run.trace is None:
        return "trace: nothing recorded, so nothing can be driven again"
    return None


def _close(one: Any, other: Any) -> bool:
    numbers = [value for value in (one, other) if isinstance(value, float)]
    return math.isclose(*numbers, rel_tol=CLOSE, abs_tol=CLOSE) if len(numbers) == 2 else bool(one == other)


def _named(machine: Any) -> str:
    return f"{machine.system}, {machine.processors} processors, Python {machine.python}, numpy {machine.numpy}"
