"""The commitment of an entry: the digest of its agent's code and files, made before the seed of a draw is known."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field

from ovman.atomic import replace_bytes
from ovman.entry import EntryError
from ovman.entry.manifest import FILE as MANIFEST
from ovman.entry.manifest import Manifest, Where, read_manifest
from ovman.leaderboard.entry import submissions
from ovman.records.draw import Draw, Sha256, Time, utc
from ovman.records.record import Name, Record, Text

FILE = "commitment.json"


class Agent(Record):
    """An agent as the manifests of its evaluations have it."""

    arm: Text
    agent: Text
    code: Text | None

    @staticmethod
    def of(manifest: Manifest) -> Agent:
        """Return the agent of an evaluation."""
        return Agent(arm=manifest.arm, agent=manifest.agent, code=manifest.code)


class Commitment(Record):
    """The commitment of an entry, "ovman-commitment/1". time: by its author's clock. files: SHA-256 by path."""

    schema_id: Literal["ovman-commitment/1"] = Field("ovman-commitment/1", alias="schema")
    entry: Name
    time: Time
    agents: tuple[Agent, ...]
    files: Mapping[Text, Sha256]


def commit_entry(directory: Path, files: Sequence[Path]) -> str:
    """Write the commitment of an entry: the agents of its evaluations on public splits, and files. Return a line to publish.

    EntryError, in one line, for an entry without an evaluation, a file that cannot be read, and a server's agent without files.
    """
    path = directory / FILE
    if path.exists():
        raise EntryError(f"{path}: is there already; its time counts. Remove it to commit to another agent")
    every = [read_manifest(one.directory) for one in submissions(directory) if one.drives and not one.is_fresh]
    agents = tuple(dict.fromkeys(map(Agent.of, every)))
    if not agents:
        raise EntryError(f"{directory}: has no evaluation on a public split; run `ovman eval` and `ovman enter` first")
    digests = {str(file): hashlib.sha256(_content(file)).hexdigest() for given in files for file in _expand(given)}
    if any(manifest.where is Where.SERVER for manifest in every) and not digests:
        raise EntryError(f"{directory}: its agent runs on a server, whose code no manifest has; name its files with --files")
    made = Commitment(entry=directory.name, time=utc(time.time()), agents=agents, files=digests)
    replace_bytes(path, made.to_line().encode())
    return f"{path}: publish it now; its SHA-256 is {hashlib.sha256(path.read_bytes()).hexdigest()}"


def read_commitment(directory: Path) -> Commitment | None:
    """Return the commitment of an entry, None if it has none. RecordError, in one line, for a wrong file."""
    path = directory / FILE
    return Commitment.parse(path.read_bytes(), str(path)) if path.is_file() else None


def reasons_uncommitted(directory: Path, manifest: Manifest, draw: Draw) -> Iterator[str]:
    """Yield lines on why runs on a draw are not those of an agent that was committed before the draw's seed was known."""
    path, found = directory / FILE, read_commitment(directory)
    if found is None:
        yield f"{path}: is not there, so nothing shows that the agent is older than the draw; commit before the next draw"
        return
    if found.entry != directory.name:
        yield f"{path}: entry: is {found.entry}, and the folder is called {directory.name}; commit again"
    if Agent.of(manifest) not in found.agents:
        yield f"{directory / draw.name / MANIFEST}: agent or code: none that {FILE} names; run the committed agent"
    since, until = seed_times(draw)
    if found.time >= until:
        yield f"{path}: time: {found.time}, but the seed of {draw.name} was public from {until}; commit before the next draw"
    if since is not None and found.time < since:
        yield f"{path}: time: {found.time}, but the seed of {draw.name} was committed at {since}, later; commit after that"


def seed_times(draw: Draw) -> tuple[str | None, str]:
    """Return between which times an entry must be committed to count on a draw: after the organiser, before the seed is public.

    EntryError for a draw whose seed somebody chose.
    """
    if draw.beacon is not None:
        return None, draw.beacon.time
    if draw.commitment is not None:
        return draw.commitment.time, draw.commitment.closes
    raise EntryError(f"{draw.name}: its seed was chosen freely; a draw that ranks has a seed of --beacon or --reveal")


def _expand(path: Path) -> list[Path]:
    return sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise EntryError(f"--files: {path}: {error.strerror}; name a file that can be read") from None
