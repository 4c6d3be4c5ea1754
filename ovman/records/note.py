"""Whether a plug-in made the records of its arms, as a record: the tables say why rows are missing.

Imports nothing heavy: the rules of a plug-in import it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from ovman.records.record import Record


class Note(Record):
    """The record results/notes/{plugin}.json.

    system: title of the system in the tables; missing: in one line what is missing and how to get it, empty where the system ran.
    """

    schema_id: Literal["ovman-note/1"] = Field("ovman-note/1", alias="schema")
    system: str
    missing: str = ""

    @property
    def ran(self) -> bool:
        """Whether the system ran."""
        return not self.missing

    @staticmethod
    def load(path: Path) -> Note:
        """Return the note of a file. Raises RecordError."""
        return Note.parse(path.read_bytes(), str(path))

    def write(self, path: Path) -> None:
        """Write the note to `path`."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.to_line(), encoding="utf-8")


def sentence(path: Path) -> str | None:
    """Return the tables' sentence about a system that did not run, given its note, or None if it ran. Raises RecordError."""
    note = Note.load(path)
    return None if note.ran else f"{note.system} was not run: results/notes/{path.name} says what is missing."
