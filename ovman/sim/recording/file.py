"""A recorded session as a file: gzip, one JSON object a line.

The first line is the `Header`. The others are, in the order in which things happened, calls of the Controller and what it
answered (`Call`), and what OVMAN's own code made of the answers (`Result`).
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

SCHEMA = "ovman-session/1"


class TapeError(ValueError):
    """A recorded session that cannot be used, or does not go on as asked; one line: file or line, what is wrong, the remedy."""


@dataclass(frozen=True)
class Header:
    """What a session was recorded of, with and on.

    embodiment: fields of `ovman.sim.embodiment.Embodiment`. constants: the canonical text of every stage whose work was done, by
    its name. versions: of OVMAN, of the client, of its build; platform: of the machine.
    """

    backend: str
    scene: str
    embodiment: Mapping[str, Any]
    constants: Mapping[str, str]
    versions: Mapping[str, str]
    platform: Mapping[str, str]


@dataclass(frozen=True)
class Call:
    """One call of the Controller: "start", "reset" or "step", with its arguments as JSON.

    Either `metadata` is there, of the event, and `pictures`, what is known of its images ("rgb", "depth", "masks"; empty where it
    had none), or `error`, the exception's type and message.
    """

    call: str
    arguments: Mapping[str, Any]
    metadata: Mapping[str, Any] | None
    pictures: Mapping[str, Any]
    error: tuple[str, str] | None = None

    @property
    def asked(self) -> str:
        """The call in a few words."""
        return f"{self.call} {json.dumps(self.arguments, sort_keys=True)}"


@dataclass(frozen=True)
class Result:
    """What a piece of OVMAN's work came to: JSON."""

    work: str
    record: Any


@dataclass(frozen=True)
class Tape:
    """A whole recorded session. Line k of the file is entry k - 2."""

    header: Header
    entries: Sequence[Call | Result]

    def calls(self) -> Iterator[tuple[int, Call]]:
        """The calls with the numbers of their lines."""
        return ((k, e) for k, e in enumerate(self.entries, start=2) if isinstance(e, Call))

    def results(self) -> dict[str, Any]:
        """Records by the name of the work."""
        return {e.work: e.record for e in self.entries if isinstance(e, Result)}


class Writer:
    """Writes a session as it happens; a context manager. What was written until an exception is a whole file."""

    def __init__(self, path: Path, header: Header) -> None:
        # Neither the name nor the time goes into the file: the same session is the same bytes.
        self._raw = path.open("wb")
        self._file = gzip.GzipFile("", "wb", compresslevel=9, fileobj=self._raw, mtime=0)
        self._line({"schema": SCHEMA, **asdict(header)})

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()
        self._raw.close()

    def write(self, entry: Call | Result) -> None:
        """Add a line."""
        self._line({key: value for key, value in vars(entry).items() if value is not None and value != {}})

    def _line(self, record: Mapping[str, Any]) -> None:
        self._file.write(json.dumps(record, separators=(",", ":")).encode() + b"\n")


def read(path: Path) -> Tape:
    """A recorded session. TapeError if the file is none."""
    try:
        with gzip.open(path, "rt", encoding="utf-8") as file:
            first, *others = [json.loads(line) for line in file]
        if first.pop("schema") != SCHEMA:
            raise TapeError(f"{path}: its schema is not {SCHEMA}; record it anew with this version")
        return Tape(Header(**first), [_entry(record) for record in others])
    except OSError as error:
        raise TapeError(f"{path}: {error.strerror or error}; give a file that `ovman record` wrote") from None
    except (EOFError, ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, TapeError):
            raise
        raise TapeError(
            f"{path}: is no recorded session ({type(error).__name__}); give a file that `ovman record` wrote"
        ) from None


def _entry(record: Mapping[str, Any]) -> Call | Result:
    if "work" in record:
        return Result(record["work"], record["record"])
    error = record.get("error")
    return Call(
        record["call"],
        record.get("arguments", {}),
        record.get("metadata"),
        record.get("pictures", {}),
        None if error is None else (error[0], error[1]),
    )
