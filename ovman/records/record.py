"""Records: frozen pydantic models that are read from JSON lines and written to them.

A record is one JSON object on one line. Numbers are rounded, so that the bytes do not depend on the processor's last bit.
"""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, from_json

from ovman.faults import options_of, printable, requirement, show

METRE_DECIMALS = 4
"""0.1 mm."""
DEGREE_DECIMALS = 2
"""0.01 degrees."""
RATIO_DECIMALS = 6

_RATIOS = frozenset({"spl", "probability"})
"""Keys of numbers that have no unit."""

Length = Annotated[float, Field(ge=0)]
"""Metres, at least 0."""
Count = Annotated[int, Field(ge=0)]
"""A number of pixels, actions, cells."""
_TEXT = r"^[^\p{Cc}\u2028\u2029\u202a-\u202e\u2066-\u2069]*$"
_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*(\.[A-Za-z0-9_-]+)*$"
_INSTANCE = r"^[^\p{Cc}/\\]*$"
Text = Annotated[str, Field(min_length=1, pattern=_TEXT)]
"""One line of text. Control characters and those that turn the direction of writing are refused."""
Name = Annotated[str, Field(max_length=200, pattern=_NAME)]
"""A name that becomes a part of a path."""
InstanceId = Annotated[str, Field(min_length=1, pattern=_INSTANCE)]
"""The id of an instance, such as "Chair|+01.00|+00.00|-02.50". The name of a visit has its first part."""


MAKE_AGAIN = "restore the line or remove the file and make it again"
"""The remedy for a line that is not JSON."""


class RecordError(ValueError):
    """A record that is not what its schema says; the message is one line with file, line, key and remedy."""


def rounded(value: Any, key: str = "") -> Any:
    """Return a value with every float in it rounded, through mappings (which name the key) and sequences (which inherit it).

    Precision: 0.01 degrees under a key that ends in "_deg", six decimals under "spl" and "probability", 0.1 mm elsewhere.
    Integers, booleans and text stay as they are, -0.0 becomes 0.0, numpy's numbers and arrays become Python's, tuples become
    lists. Applying it twice changes nothing. ValueError for a number that is not finite, which JSON cannot hold.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {name: rounded(inner, str(name)) for name, inner in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [rounded(inner, key) for inner in value]
    if not isinstance(value, float):
        return value
    if not math.isfinite(value):
        raise ValueError(f"{key or 'a number'} is {value}: a record holds finite numbers only")
    decimals = RATIO_DECIMALS if key in _RATIOS else DEGREE_DECIMALS if key.endswith("_deg") else METRE_DECIMALS
    return round(value, decimals) + 0.0


def line(record: Mapping[str, Any]) -> str:
    """Return a record as one line of JSON with its newline, rounded, keys in the order given: equal records have equal bytes."""
    return json.dumps(rounded(record), separators=(",", ":"), ensure_ascii=False, allow_nan=False) + "\n"


def records(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the records of a JSONL file, each with its place, "file:line". RecordError for a line that is not JSON."""
    for place, text in read_lines(path):
        try:
            yield place, from_json(text)
        except ValueError as error:
            raise RecordError(f"{place}: not JSON ({error}); {MAKE_AGAIN}") from None


def read_lines(path: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the lines of a JSONL file that are not empty, each with its place."""
    with Path(path).open("rb") as file:
        yield from ((f"{path}:{number}", text) for number, text in enumerate(file, start=1) if text.strip())


class Record(BaseModel):
    """A record. Fields are in the order of the file's keys; unknown keys are ignored.

    Types are strict: 2.0 is not an integer, true is not a number. A field `schema_id` (key "schema") names the schema; it is
    checked first.
    """

    # Built at the first validation: a job starts sooner than with the validators of all records.
    model_config = ConfigDict(
        frozen=True, extra="ignore", strict=True, allow_inf_nan=False, populate_by_name=True, defer_build=True
    )

    @classmethod
    def from_json(cls, value: Any, place: str = "record") -> Self:
        """Return the record of a JSON value. place: file and line, for the message.

        Raises RecordError, one line with place, key and remedy, for a key that is missing, a value of the wrong kind, another
        schema, or a record that contradicts itself.
        """
        return cls.parse(json.dumps(value), place)

    @classmethod
    def parse(cls, text: str | bytes, place: str = "record") -> Self:
        """Return the record of a JSON text. Raises RecordError as `from_json`."""
        try:
            made = cls.model_validate_json(text)
        except ValidationError as error:
            raise RecordError(complaint(error, place)) from None
        if "schema_id" in cls.model_fields and "schema_id" not in made.model_fields_set:
            raise RecordError(f"{place}: schema: the key is missing; make the file again with this version of ovman")
        return made

    @classmethod
    def read(cls, path: Path) -> list[Self]:
        """Return the records of a JSONL file in its order. Raises RecordError as `from_json`, and for a line that is not JSON."""
        return [cls.parse(text, place) for place, text in read_lines(path)]

    def to_json(self) -> dict[str, Any]:
        """Return the record as JSON values, rounded, keys in the order of the fields."""
        return dict(rounded(self.model_dump(mode="json", by_alias=True)))

    def to_line(self) -> str:
        """Return the record as a line of a JSONL file."""
        return line(self.to_json())


def optional(**terms: Any) -> Any:
    """Return a field, None by default, whose key is left out of files if it is None. terms: of pydantic's `Field`."""
    return Field(None, exclude_if=lambda value: value is None, **terms)


def unless_default(default: Any) -> Any:
    """Return a field whose key is left out of files if it has its default value."""
    return Field(default, exclude_if=lambda value: value == default)


def lines(written: Iterable[Record]) -> str:
    """Return records as the text of a JSONL file."""
    return "".join(record.to_line() for record in written)


def complaint(error: ValidationError, place: str) -> str:
    """Return the fault of a record in one line: place, key, complaint, remedy. A wrong schema goes first, a missing key last."""
    first = min(error.errors(), key=lambda one: 0 if one["loc"][:1] == ("schema",) else 2 if one["type"] == "missing" else 1)
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"] if part != "[key]")
    where = ": ".join(filter(None, (place, "".join(parts).removeprefix("."))))
    says, remedy = _said(first)
    return printable(" ".join(f"{where}: {says}; {remedy}".split()))


_FORMS = {
    _TEXT: "one line without control characters",
    _NAME: "a name of letters, digits, _ and -, with single dots between them",
    _INSTANCE: "an instance without / and control characters",
}
"""Patterns of text in words."""


def _said(error: ErrorDetails) -> tuple[str, str]:
    """Return complaint and remedy of pydantic's error."""
    kind, value = error["type"], error["input"]
    if kind == "json_invalid":
        return f"not JSON ({error['ctx']['error']})", MAKE_AGAIN
    if kind == "missing":
        near = difflib.get_close_matches(str(error["loc"][-1]), [str(name) for name in value], n=1)
        return "the key is missing", f"rename {near[0]!r}" if near else "add it or make the file again"
    if options := options_of(error):
        if error["loc"][-1:] == ("schema",):
            return f"expected {options[0]!r}, found {value!r}", "make the file again with this version of ovman"
        near = difflib.get_close_matches(str(value), options, n=1) or [" or ".join(options)]
        return f"{show(value, 40)} is not one of {', '.join(options)}", f"write {near[0]}"
    expected = _FORMS.get(error.get("ctx", {}).get("pattern", ""), requirement(error))
    if expected is None:
        return error["msg"].removeprefix("Value error, "), "correct the record or make the file again"
    return f"expected {expected}, found {show(value, 40)}", "correct it or make the file again"
