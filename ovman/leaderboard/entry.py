"""A folder of the leaderboard: who enters what, and a folder a split with runs of one evaluation, or with predicted points."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from pathlib import Path
from typing import Any

import yaml
from pydantic import ConfigDict, Field

from ovman.entry import EntryError
from ovman.records.record import Record, Text
from ovman.settings import settings_files

FILE = "entry.yaml"
PREDICTIONS = "predictions.jsonl"
MOST_BYTES = 4096
"""Of `entry.yaml`."""
NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")


class Role(StrEnum):
    """SYSTEM: is ranked. CONTROL: lacks something that the task is said to need. DIAGNOSTIC: is handed some of the truth."""

    SYSTEM = "system"
    CONTROL = "control"
    DIAGNOSTIC = "diagnostic"


class Entry(Record):
    """Who enters what: `entry.yaml`.

    system: what the table calls it. role: in which block it stands. authors: as they want to be named. date: of the entry,
    YYYY-MM-DD. code: where its code is, so that others can run it; None where it is nowhere. about: what it is, in one line.
    """

    model_config = ConfigDict(extra="forbid")

    system: Text = Field(max_length=60)
    role: Role
    authors: tuple[Text, ...] = Field(min_length=1)
    date: str = Field(pattern=r"^\d{4}-\d{2}-\d{2}$")
    code: str | None = Field(pattern=r"^https://[^\s()<>\[\]|`\\\"\p{C}]+$")
    about: Text = Field(max_length=300)


@dataclass(frozen=True, slots=True)
class Submission:
    """An evaluation, or predicted points, of an entry on a split or a draw.

    split: name of either. directory: its folder; drives: whether it holds an evaluation, else predicted points.
    """

    name: str
    entry: Entry
    split: str
    directory: Path
    drives: bool

    @property
    def is_fresh(self) -> bool:
        """Whether it is of a draw, whose name has a hyphen; that of a split has none."""
        return "-" in self.split

    @property
    def place(self) -> str:
        """How messages call it."""
        return f"{self.name}/{self.split}"


def read_entry(directory: Path) -> Entry:
    """Return the `entry.yaml` of a folder. ConfigError, EntryError or RecordError, in one line, for a wrong file.

    The file may come from anybody. It has `MOST_BYTES` at most, and neither anchors nor aliases.
    """
    path = directory / FILE
    if not path.is_file():
        raise EntryError(f"{path}: is not there; write it, or make the entry with `ovman enter`")
    if path.stat().st_size > MOST_BYTES:
        raise EntryError(f"{path}: has more than {MOST_BYTES} bytes; shorten it")
    value: Any = settings_files.read(path)
    if any(isinstance(token, yaml.AnchorToken | yaml.AliasToken) for token in yaml.scan(path.read_text(encoding="utf-8"))):
        raise EntryError(f"{path}: has an anchor (&) or an alias (*); write the values out")
    if isinstance(value, dict):
        value = {str(key): str(one) if key == "date" else one for key, one in value.items()}
    return Entry.from_json(value, str(path))


def submissions(directory: Path) -> Iterator[Submission]:
    """Yield the submissions of an entry's folder by split. ConfigError, EntryError or RecordError, in one line, for others."""
    if not NAME.fullmatch(directory.name):
        raise EntryError(f"{directory}: is no name of an entry; write small letters, digits, - and _")
    for path in chain([directory], directory.rglob("*")):
        if path.is_symlink():
            raise EntryError(f"{path}: is a link; put in the file or the folder itself")
    entry = read_entry(directory)
    splits = sorted(path for path in directory.iterdir() if path.is_dir())
    if not splits:
        raise EntryError(f"{directory}: holds no split; put an evaluation or {PREDICTIONS} into a folder named after its split")
    for split in splits:
        if not NAME.fullmatch(split.name):
            raise EntryError(f"{split}: is not the name of a split; name the folder after its split")
        drives, static = (split / "manifest.json").is_file(), (split / PREDICTIONS).is_file()
        if not drives and not static:
            raise EntryError(f"{split}: holds neither an evaluation nor {PREDICTIONS}; put in one, or remove it")
        for has in [True] * drives + [False] * static:
            yield Submission(directory.name, entry, split.name, split, has)


def write_entry(directory: Path, entry: Entry) -> None:
    """Write `entry.yaml`."""
    value = json.loads(entry.model_dump_json())
    (directory / FILE).write_text(yaml.safe_dump(value, sort_keys=False, allow_unicode=True, width=120), encoding="utf-8")
