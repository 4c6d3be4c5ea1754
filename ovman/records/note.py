"""Whether a plug-in made the records of its arms, as a record: the tables say why rows are missing.

Imports nothing heavy: the rules of a plug-in import it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

SCHEMA: Literal["ovman-note/1"] = "ovman-note/1"


class NoteError(ValueError):
    """A file that is not a note; one line with the file and the remedy."""


class Note(BaseModel):
    """The record results/notes/{plugin}.json.

    system: title of the system in the tables; missing: in one line what is missing and how to get it, empty where the system ran.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    schema_id: Literal["ovman-note/1"] = Field(SCHEMA, alias="schema")
    system: str
    missing: str = ""

    @property
    def ran(self) -> bool:
        """Whether the system ran."""
        return not self.missing

    @staticmethod
    def read(path: Path) -> Note:
        """Return the note of a file. Raises NoteError."""
        try:
            return Note.model_validate_json(path.read_bytes())
        except ValidationError as error:
            reason = error.errors()[0]["msg"]
            raise NoteError(f"{path}: is not a record {SCHEMA!r} ({reason}); remove it to make it again") from None

    def write(self, path: Path) -> None:
        """Write the note to `path`."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.model_dump_json(by_alias=True) + "\n", encoding="utf-8")


def sentence(path: Path) -> str | None:
    """Return the tables' sentence about a system that did not run, given its note, or None if it ran. Raises NoteError."""
    note = Note.read(path)
    return None if note.ran else f"{note.system} was not run: results/notes/{path.name} says what is missing."
