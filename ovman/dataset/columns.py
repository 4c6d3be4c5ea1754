"""What the tables of the data set consist of. One definition of a column serves Arrow, Hugging Face, Croissant and the card."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

TRUTH = "truth_"
"""How the name of a column begins that only the evaluator may read."""


@dataclass(frozen=True, slots=True)
class Form:
    """What a kind of column is called by pyarrow, by Hugging Face (`feature`), by Croissant, and in the card (`said`)."""

    arrow: str
    feature: str
    croissant: str
    said: str


class Kind(Enum):
    """Kinds of columns. A JSON column is text that holds one JSON value; an IMAGE is the bytes of a PNG."""

    TEXT = Form("string", "string", "sc:Text", "text")
    JSON = Form("string", "string", "sc:Text", "JSON")
    WHOLE = Form("int64", "int64", "sc:Integer", "integer")
    REAL = Form("float64", "float64", "sc:Float", "number")
    FLAG = Form("bool", "bool", "sc:Boolean", "true or false")
    IMAGE = Form("image", "image", "sc:ImageObject", "PNG")


@dataclass(frozen=True, slots=True)
class Column:
    """A column. about: what it holds, with unit and frame, as card and Croissant say it."""

    name: str
    kind: Kind
    about: str

    @property
    def truth(self) -> bool:
        """Whether only the evaluator may read it."""
        return self.name.startswith(TRUTH)


@dataclass(frozen=True, slots=True)
class Table:
    """A configuration of the data set: its name, what a row is, and its columns in their order."""

    name: str
    about: str
    columns: tuple[Column, ...]

    @property
    def pictured(self) -> bool:
        """Whether rows hold pictures; such a table has a file for each floor plan."""
        return any(column.kind is Kind.IMAGE for column in self.columns)

    def file(self, split: str, part: str) -> str:
        """Name of a file of a split; part: of a floor plan in a table with pictures. "*" for either makes a pattern."""
        return f"{self.name}/{split}/{part}.parquet" if self.pictured else f"{self.name}/{split}.parquet"

    @property
    def features(self) -> dict[str, Any]:
        """The columns as Hugging Face names their types, as a Parquet file carries them."""
        return {
            column.name: {"_type": "Image"}
            if column.kind is Kind.IMAGE
            else {"dtype": column.kind.value.feature, "_type": "Value"}
            for column in self.columns
        }

    def row(self, values: dict[str, Any]) -> dict[str, Any]:
        """The values in the order of the columns. ValueError where a column has none, or a value has no column."""
        names = [column.name for column in self.columns]
        if wrong := set(names) ^ set(values):
            raise ValueError(f"table {self.name}: {sorted(wrong)} are columns without a value, or values without a column")
        return {name: values[name] for name in names}
