"""The folder of an evaluation: its manifest (episodes, agent, seeds, versions, machines) and its runs."""

from __future__ import annotations

import gzip
import hashlib
import os
import platform
import zlib
from collections.abc import Iterator, Sequence
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Literal, cast

from pydantic import Field

from ovman import __version__
from ovman.atomic import replace_bytes
from ovman.entry import EntryError
from ovman.provenance import digest_code
from ovman.records.episode import SCHEMA as EPISODE
from ovman.records.record import Count, Name, Record, Text, optional, unless_default
from ovman.records.run import Score
from ovman.remote.isolation import Isolation, describe
from ovman.settings import Source
from ovman.settings.arms import ArmJob, Track

FILE, LOG = "manifest.json", "agent.log"
"""Files of an evaluation's folder: its manifest, and the output of an agent whose process the evaluator started."""
HANDED = ("grounding", "positions", "answer")
"""What of the truth an arm may be given."""
RUNS = "runs.jsonl"
COMPRESSED = f"{RUNS}.gz"
MOST_BYTES = 100_000_000
"""Largest file of runs, uncompressed: the file may come from anybody, and a compressed one may hold anything."""


class Where(StrEnum):
    """Where the agent ran.

    EVALUATOR: in the evaluator's process, where the truth is; PROCESS: in a process of its own, started by the evaluator; SERVER:
    on a server that the evaluator connected to.
    """

    EVALUATOR = "evaluator"
    PROCESS = "process"
    SERVER = "server"


class Machine(Record):
    """The machine of runs."""

    system: Text
    machine: str = Field(pattern=r"^\P{Cc}*$")
    processors: int | None
    python: Text
    numpy: Text


class Repeated(Record):
    """A run that took several attempts: the agent was shown its drive, and the run began again."""

    episode: Text
    seed: int
    attempts: Count


class Manifest(Record):
    """One evaluation, "ovman-manifest/1".

    split: the released split that the episodes are, None for others. draw: name of the draw that they are. sha256: of the
    file of episodes. n: how many it has; asked: ids of those that are run, in their order. code: digest of the agent's module
    and of what it imports from its own package and from ovman. where: the agent ran. handed: what of the truth the agent is
    given; with any it is a diagnostic and no system. embodiment: body and camera. any_instance: whether reaching any instance
    of the category is judged, too. budget: actions of an episode, None for that of its protocol. marks: numbers of actions at
    which the path length is recorded. ovman, engine, protocol: versions. machines: those that the runs were made on. nonce:
    draws of the agent, the order of the episodes and all digests that were sent follow from it; None for an arm of config.yaml,
    whose runs can be made again. repeated: runs that took several attempts; earlier versions, which did not count, say nothing.
    isolation: of an agent in a process, None for others and earlier versions. track: the form of its queries; files leave
    out the paper's.
    """

    schema_id: Literal["ovman-manifest/1"] = Field("ovman-manifest/1", alias="schema")
    split: Name | None
    draw: Name | None = optional()
    sha256: Text
    n: Count
    asked: tuple[Text, ...]
    seeds: tuple[Count, ...]
    arm: Text
    agent: Text
    needs: tuple[Text, ...]
    where: Where
    code: Text | None
    handed: tuple[Text, ...]
    embodiment: Literal["default", "locobot"]
    any_instance: bool
    budget: int | None = Field(ge=1)
    marks: tuple[Count, ...]
    ovman: Text
    engine: Text | None
    protocol: Text
    machines: tuple[Machine, ...]
    nonce: Text | None = optional()
    repeated: tuple[Repeated, ...] = ()
    isolation: Isolation | None = optional()
    track: Track = unless_default(Track.PAPER)

    @property
    def ran(self) -> str:
        """Where the agent ran, whether it was isolated, and the track if it is not the paper's."""
        track = "" if self.track is Track.PAPER else f", {self.track} track"
        return f"{self.where}, {describe(self.isolation)}{track}"

    @property
    def is_whole(self) -> bool:
        """Whether all episodes are asked for: only then a rate is a score."""
        return len(self.asked) == self.n


def manifest_of(
    arm: ArmJob,
    episodes: bytes,
    split: str | None,
    n: int,
    asked: Sequence[str],
    seeds: Sequence[int],
    where: Where,
    nonce: str | None = None,
    isolation: Isolation | None = None,
    draw: str | None = None,
) -> Manifest:
    """Return the manifest of an evaluation on this machine. episodes: The bytes of their file, n of them."""
    return Manifest(
        split=split,
        draw=draw,
        sha256=hashlib.sha256(episodes).hexdigest(),
        n=n,
        asked=tuple(asked),
        seeds=tuple(seeds),
        arm=arm.name,
        agent=arm.agent,
        needs=tuple(map(str, arm.needs)),
        where=where,
        code=digest_code(arm.agent.partition(":")[0]),
        handed=tuple(what for what in HANDED if getattr(arm, what) is Source.HANDED),
        embodiment=arm.embodiment,
        any_instance=arm.any_instance,
        budget=arm.budget,
        marks=arm.marks,
        ovman=__version__,
        engine=engine_version(),
        protocol=EPISODE,
        machines=(this_machine(),),
        nonce=nonce,
        isolation=isolation,
        track=arm.track,
    )


def this_machine() -> Machine:
    """Return the machine that this process runs on."""
    system, python = platform.platform(), platform.python_version()
    return Machine(system=system, machine=platform.machine(), processors=os.cpu_count(), python=python, numpy=version("numpy"))


def claim_folder(directory: Path, manifest: Manifest) -> Manifest:
    """Begin an evaluation in a folder, or continue it there; return its manifest as it is written.

    Seeds that the folder has stay, and those of `manifest` are added. An evaluation without a run is replaced.

    Raises:
        EntryError: The folder holds an evaluation of another arm, one on episodes that are not asked for now, or something else.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise EntryError(f"--out: {directory} is a file, or lies below one; name a folder") from None
    there = {path.name for path in directory.iterdir() if not path.name.startswith(".")}
    if there - {LOG} and FILE not in there:
        raise EntryError(f"--out: {directory} holds something else than an evaluation; name another folder")
    if there - {FILE, LOG}:
        known = read_manifest(directory)
        for key in ("arm", "agent", "track", "where", "isolation", "split", "sha256"):
            before, now = getattr(known, key), getattr(manifest, key)
            if before != now:
                raise EntryError(
                    f"--out: {directory} holds an evaluation whose {key} is {before}, not {now}; name another folder"
                )
        if lost := sorted(set(known.asked) - set(manifest.asked)):
            raise EntryError(
                f"--out: {directory} holds runs on {len(lost)} episodes that are not asked for now, such as {lost[0]}; "
                "ask for them, too, or name another folder"
            )
        manifest = manifest.model_copy(update={"nonce": known.nonce})
        for key in ("seeds", "machines", "repeated"):
            manifest = manifest.model_copy(update={key: tuple(dict.fromkeys([*getattr(known, key), *getattr(manifest, key)]))})
    elif FILE in there:
        read_manifest(directory)  # what is replaced is an evaluation's
    write_manifest(directory, manifest)
    return manifest


def write_manifest(directory: Path, manifest: Manifest) -> None:
    """Write the manifest of an evaluation into its folder."""
    replace_bytes(directory / FILE, manifest.to_line().encode())


def read_manifest(directory: Path) -> Manifest:
    """Return the manifest of an evaluation. EntryError, in one line, if there is none or it is damaged."""
    path = directory / FILE
    try:
        found = Manifest.read(path)
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}; name a folder that `ovman eval` wrote") from None
    if len(found) != 1:
        raise EntryError(f"{path}: holds {len(found)} manifests; name a folder that `ovman eval` wrote")
    return found[0]


def engine_version() -> str | None:
    """Return the version of the embedded engine, None if it is not installed."""
    try:
        return version("ovman-engine")
    except PackageNotFoundError:
        return None


def runs_path(directory: Path) -> Path:
    """Return the file of the runs of an evaluation, the plain one if there is a compressed one too. EntryError for neither."""
    for path in (directory / RUNS, directory / COMPRESSED):
        if path.is_file():
            return path
    raise EntryError(f"{directory / RUNS}: the file is missing; an evaluation that was interrupted goes on by the same command")


def read_runs(path: Path) -> Iterator[tuple[str, Score]]:
    """Yield the runs of a file, each with its place, "file:line". RecordError or EntryError, in one line, for a wrong file."""
    try:
        with cast(BinaryIO, gzip.open(path) if path.suffix == ".gz" else path.open("rb")) as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise EntryError(f"{path}: cannot be read ({error}); make the file again") from None
    if len(content) > MOST_BYTES:
        raise EntryError(f"{path}: more than {MOST_BYTES} bytes; a run has a few hundred")
    for number, text in enumerate(BytesIO(content), start=1):
        place = f"{path}:{number}"
        yield place, Score.parse(text.decode("utf-8", errors="replace"), place)


def compress_runs(source: Path) -> bytes:
    """Return the runs of an evaluation compressed; equal contents have equal bytes."""
    path = runs_path(source)
    return path.read_bytes() if path.name == COMPRESSED else gzip.compress(path.read_bytes(), mtime=0)
