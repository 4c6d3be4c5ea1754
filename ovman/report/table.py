"""A table before it is written: columns, rows and a caption, the same for csv, Markdown and LaTeX."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple


class Format(Enum):
    """Where a column is written."""

    CSV = "csv"
    MARKDOWN = "md"
    LATEX = "tex"


EVERYWHERE = frozenset(Format)
DATA = frozenset({Format.CSV})
PAGE = frozenset({Format.MARKDOWN, Format.LATEX})
CSV_AND_MARKDOWN = frozenset({Format.CSV, Format.MARKDOWN})


class Text(NamedTuple):
    """Words that LaTeX writes differently: ``tex`` is LaTeX source, ``plain`` is for everywhere else."""

    plain: str
    tex: str


Words = str | Text


@dataclass(frozen=True, slots=True)
class Column:
    """key: the csv's header and the key of the rows' cells. title: its header on a page. numeric: aligned to the right."""

    key: str
    title: Words
    numeric: bool = False
    formats: frozenset[Format] = EVERYWHERE


@dataclass(frozen=True, slots=True)
class Row:
    """cells: by the key of their column; a cell that is not there is empty in the csv and a dash on a page.

    section: the heading that LaTeX sets above the first row of each section, None for no heading.
    """

    cells: Mapping[str, Words]
    section: str | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """name: of its files and, after "tab:", its LaTeX label. wide: LaTeX sets it across both columns of a page."""

    name: str
    caption: Words
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    wide: bool = False

    def __post_init__(self) -> None:
        keys = [column.key for column in self.columns]
        if len(set(keys)) < len(keys):
            raise ValueError(f"table {self.name}: two columns have one key")
        strangers = sorted({key for row in self.rows for key in row.cells} - set(keys))
        if strangers:
            raise ValueError(f"table {self.name}: no column for {', '.join(strangers)}")

    def columns_in(self, form: Format) -> tuple[Column, ...]:
        """The columns that a format shows."""
        return tuple(column for column in self.columns if form in column.formats)


def plain(words: Words) -> str:
    """Words without LaTeX."""
    return words.plain if isinstance(words, Text) else words


def csv_text(table: Table) -> str:
    """RFC 4180 with a line feed at each end of line; headers are the columns' keys."""
    columns = table.columns_in(Format.CSV)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.key for column in columns])
    for row in table.rows:
        writer.writerow([plain(row.cells.get(column.key, "")) for column in columns])
    return text.getvalue()
