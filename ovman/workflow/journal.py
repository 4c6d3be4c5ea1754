"""A journal keeps every finished unit of a long job, so that a killed job redoes only the unit that it was in.

One JSON line a unit, keyed by a digest of all that the unit depends on. Every line carries a digest of its own content. Opening
a journal drops the lines that are torn, changed or without a digest, and prints one line about each; their units are made again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.atomic import durable_append, replace_bytes


def digest(*parts: Any) -> str:
    """Hexadecimal digest (24 digits) of JSON-serialisable parts, independent of key order."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Fault:
    """A line of a journal that cannot be used. line: its number from 1."""

    line: int
    problem: str


@dataclass(frozen=True)
class Contents:
    """What a journal holds. units: records by key. lines: the usable lines as bytes, in their order. faults: the other lines."""

    units: dict[str, Any]
    lines: Sequence[bytes]
    faults: Sequence[Fault]


def contents(path: Path) -> Contents:
    """Read a journal without changing it. OSError where the file cannot be read."""
    units: dict[str, Any] = {}
    lines: list[bytes] = []
    faults: list[Fault] = []
    *whole, torn = path.read_bytes().split(b"\n")
    for number, line in enumerate(whole, 1):
        try:
            key, record = _unit(line)
        except ValueError as error:
            faults.append(Fault(number, str(error)))
        else:
            units[key] = record
            lines.append(line)
    if torn:
        faults.append(Fault(len(whole) + 1, "is torn"))
    return Contents(units, lines, faults)


class Journal:
    """Finished units of one job, on disk at `path`; opened and repaired on construction."""

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._units: dict[str, Any] = {}
        if self.path.exists():
            self._load()

    def _load(self) -> None:
        found = contents(self.path)
        self._units = found.units
        if found.faults:
            for fault in found.faults:
                print(f"{self.path}, line {fault.line}: {fault.problem}; its unit is made again", flush=True)
            replace_bytes(self.path, b"".join(line + b"\n" for line in found.lines))

    def __contains__(self, key: str) -> bool:
        return key in self._units

    def __getitem__(self, key: str) -> Any:
        return self._units[key]

    def write(self, key: str, record: Any) -> Any:
        """Keep `record` (JSON-serialisable) under `key` and return it as it will be read; it survives a SIGKILL from then on."""
        body = _body(key, record)
        durable_append(self.path, f"{body[:-1]},{_digest_field(body)}}}\n".encode())
        self._units[key] = json.loads(body)["record"]
        return self._units[key]

    def unit(self, key: str, measure: Callable[[], Any]) -> Any:
        """The record under `key`, measured and kept first if it is not there yet."""
        return self._units[key] if key in self._units else self.write(key, measure())


def _body(key: str, record: Any) -> str:
    return json.dumps({"key": key, "record": record}, separators=(",", ":"))


def _digest_field(body: str) -> str:
    return f'"digest":"{hashlib.sha256(body.encode()).hexdigest()[:24]}"'


def _unit(line: bytes) -> tuple[str, Any]:
    """Key and record of a line. ValueError says what is wrong with it."""
    try:
        unit = json.loads(line.decode())
    except ValueError:
        raise ValueError("is not JSON in UTF-8") from None
    if not isinstance(unit, dict) or not isinstance(unit.get("key"), str) or "record" not in unit:
        raise ValueError("has no key or no record")
    if "digest" not in unit:
        raise ValueError("has no digest of its content")
    if _digest_field(_body(unit["key"], unit["record"])) != f'"digest":"{unit["digest"]}"':
        raise ValueError("its content does not match its digest")
    return unit["key"], unit["record"]
