"""Records: how the numbers of shared files are rounded, written and read.

A record is one JSON object on one line. Rounding makes its bytes independent of the processor's last bit.
"""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

METRE_DECIMALS = 4
"""0.1 mm."""
DEGREE_DECIMALS = 2
"""0.01 degrees."""
RATIO_DECIMALS = 6

_RATIOS = frozenset({"spl", "probability"})
"""Keys of numbers that have no unit."""

T = TypeVar("T")


class RecordError(ValueError):
    """A record that is not what its schema says; the message is one line with file, line, key and remedy."""


def rounded(value: Any, key: str = "") -> Any:
    """`value` with every float in it rounded: to 0.01 degrees under a key that ends in "_deg", to six decimals under "spl" and
    "probability", to 0.1 mm elsewhere. Applied through mappings (which name the key) and sequences (which inherit it).

    Integers, booleans and text stay as they are, -0.0 becomes 0.0, numpy's numbers and arrays become Python's and tuples lists.
    Applying it twice changes nothing. Raises ValueError for a number that is not finite, which JSON cannot hold.
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
    """A record as one line of JSON with its newline, rounded, keys in the order given: equal records have equal bytes."""
    return json.dumps(rounded(record), separators=(",", ":"), ensure_ascii=False, allow_nan=False) + "\n"


def records(path: Path) -> Iterator[tuple[str, Any]]:
    """The records of a JSONL file, each with its place, "file:line". RecordError for a line that is not JSON."""
    with Path(path).open(encoding="utf-8") as file:
        for number, text in enumerate(file, start=1):
            if not text.strip():
                continue
            place = f"{path}:{number}"
            try:
                yield place, json.loads(text)
            except json.JSONDecodeError as error:
                remedy = "restore the line or remove the file and make it again"
                raise RecordError(f"{place}: not JSON ({error.msg} at column {error.colno}); {remedy}") from None


def read_records(path: Path) -> list[Any]:
    """The records of a JSONL file in its order. RecordError as `records`."""
    return [record for _, record in records(path)]


@dataclass(frozen=True)
class Node:
    """A value inside a record that knows where it stands, so that every complaint about it can say so."""

    value: Any
    place: str
    key: str = ""

    def fail(self, complaint: str, remedy: str) -> RecordError:
        """The error to raise: one line with the place, the key, what is wrong and what to do."""
        where = f"{self.place}: {self.key}" if self.key else self.place
        return RecordError(" ".join(f"{where}: {complaint}; {remedy}".split()))

    def __getitem__(self, name: str) -> Node:
        """The value under `name` of an object; RecordError where this is no object or has no such key."""
        here = self.mapping()
        key = f"{self.key}.{name}" if self.key else name
        if name not in here:
            near = difflib.get_close_matches(name, map(str, here), n=1)
            remedy = f"rename {near[0]!r}" if near else "add it or make the file again"
            raise Node(None, self.place, key).fail("the key is missing", remedy)
        return Node(here[name], self.place, key)

    def mapping(self) -> Mapping[str, Any]:
        if not isinstance(self.value, Mapping):
            raise self.fail(f"expected an object, found {_shown(self.value)}", "write {...}")
        return self.value

    def items(self) -> Iterator[tuple[str, Node]]:
        for name in self.mapping():
            yield name, self[name]

    def elements(self) -> Iterator[Node]:
        if not isinstance(self.value, list):
            raise self.fail(f"expected a list, found {_shown(self.value)}", "write [...]")
        for index, inner in enumerate(self.value):
            yield Node(inner, self.place, f"{self.key}[{index}]")

    def number(self) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or not math.isfinite(self.value):
            raise self.fail(f"expected a number, found {_shown(self.value)}", "write a finite number")
        return float(self.value)

    def length(self) -> float:
        if self.number() < 0.0:
            raise self.fail(f"expected a length, found {_shown(self.value)}", "write metres, at least 0")
        return float(self.value)

    def integer(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            raise self.fail(f"expected an integer, found {_shown(self.value)}", "write a whole number")
        return self.value

    def boolean(self) -> bool:
        if not isinstance(self.value, bool):
            raise self.fail(f"expected true or false, found {_shown(self.value)}", "write true or false")
        return self.value

    def text(self) -> str:
        if not isinstance(self.value, str) or not self.value:
            raise self.fail(f"expected text, found {_shown(self.value)}", 'write "..."')
        return self.value

    def one_of(self, options: Sequence[str]) -> str:
        if self.value not in options:
            near = difflib.get_close_matches(str(self.value), options, n=1) or [" or ".join(options)]
            raise self.fail(f"{_shown(self.value)} is not one of {', '.join(options)}", f"write {near[0]}")
        return str(self.value)

    def optional(self, read: Callable[[Node], T]) -> T | None:
        """What `read` makes of this value, None for null."""
        return None if self.value is None else read(self)


def _shown(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 40 else text[:37] + "..."
