"""A table as GitHub-flavoured Markdown whose columns also line up on a terminal."""

from __future__ import annotations

import textwrap
import unicodedata
from collections.abc import Sequence

from ovman.report.table import Format, Table, plain

EMPTY = "—"
CAPTION_WIDTH = 110


def markdown(table: Table) -> str:
    """The caption, an empty line, the table, and a line feed at the end."""
    columns = table.columns_in(Format.MARKDOWN)
    header = [_escaped(plain(column.title)) for column in columns]
    body = [[_escaped(plain(row.cells.get(column.key, "")) or EMPTY) for column in columns] for row in table.rows]
    caption = textwrap.wrap(plain(table.caption), CAPTION_WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join([*caption, ""]) + "\n" + pipe_table(header, body, [column.numeric for column in columns])


def pipe_table(header: Sequence[str], body: Sequence[Sequence[str]], numeric: Sequence[bool]) -> str:
    """The table alone, with a line feed at the end; `numeric` columns are aligned to the right."""
    widths = [max(3, *(_width(line[index]) for line in [header, *body])) for index in range(len(header))]
    rule = ["-" * (width - 1) + ":" if right else "-" * width for right, width in zip(numeric, widths, strict=True)]
    return "\n".join(_line(cells, numeric, widths) for cells in (header, rule, *body)) + "\n"


def _line(cells: Sequence[str], numeric: Sequence[bool], widths: Sequence[int]) -> str:
    padded = []
    for cell, right, width in zip(cells, numeric, widths, strict=True):
        space = " " * (width - _width(cell))
        padded.append(space + cell if right else cell + space)
    return "| " + " | ".join(padded) + " |"


def _width(text: str) -> int:
    """Columns of a terminal: combining marks take none."""
    return sum(not unicodedata.combining(character) for character in text)


def _escaped(text: str) -> str:
    return text.replace("|", r"\|")
