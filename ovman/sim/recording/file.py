"""A recorded session as a file: gzip, one JSON object a line.

The first line is the `Header`. The other lines follow in the order of events: calls of the Controller with their answers
(`Call`), and what OVMAN's own code derived from the answers (`Result`).
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

SCHEMA = "ovman-session/1"


class RecordingError(ValueError):
    """A recorded session that is unusable or asked for another call; one line: file or line, what is wrong, the remedy."""


@dataclass(frozen=True)
class Header:
    """What was recorded, with which settings, and on which machine.

    embodiment: fields of `ovman.sim.embodiment.Embodiment`. constants: the parameter of every stage whose work was done, by the
    stage's name. versions: of OVMAN, of the client, of its build; platform: of the machine.
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

    metadata: of the event; pictures: statistics of its images ("rgb", "depth", "masks"; empty for an event without images);
    error: type and message of the exception that the call raised; then metadata is None.
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
    """The result of a piece of OVMAN's work, as JSON."""

    work: str
    record: Any


@dataclass(frozen=True)
class Recording:
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
    """Writes a session as it happens; a context manager. After an exception the file is complete up to the last entry."""

    def __init__(self, path: Path, header: Header) -> None:
        # The file contains neither its name nor the time: equal sessions have equal bytes.
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


def read(path: Path) -> Recording:
    """A recorded session. RecordingError if the file is no recorded session."""
    try:
        with gzip.open(path, "rt", encoding="utf-8") as file:
            first, *others = [json.loads(line) for line in file]
        if first.pop("schema") != SCHEMA:
            raise RecordingError(f"{path}: its schema is not {SCHEMA}; record it anew with this version")
        return Recording(Header(**first), [_entry(record) for record in others])
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror or error}; give a file that `ovman record` wrote") from None
    except (EOFError, ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(
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
