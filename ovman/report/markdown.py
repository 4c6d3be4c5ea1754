"""A table as GitHub-flavoured Markdown whose columns also line up on a terminal."""

from __future__ import annotations

import textwrap
import unicodedata

from ovman.report.table import Column, Format, Table, plain

EMPTY = "—"
CAPTION_WIDTH = 110


def markdown(table: Table) -> str:
    """The caption, an empty line, the table, and a line feed at the end."""
    columns = table.columns_in(Format.MARKDOWN)
    header = [_escaped(plain(column.title)) for column in columns]
    body = [[_escaped(plain(row.cells.get(column.key, "")) or EMPTY) for column in columns] for row in table.rows]
    widths = [max(3, *(_width(line[index]) for line in [header, *body])) for index in range(len(columns))]
    rule = ["-" * (width - 1) + ":" if column.numeric else "-" * width for column, width in zip(columns, widths, strict=True)]
    lines = [_line(cells, columns, widths) for cells in (header, rule, *body)]
    caption = textwrap.wrap(plain(table.caption), CAPTION_WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join([*caption, "", *lines]) + "\n"


def _line(cells: list[str], columns: tuple[Column, ...], widths: list[int]) -> str:
    padded = []
    for cell, column, width in zip(cells, columns, widths, strict=True):
        space = " " * (width - _width(cell))
        padded.append(space + cell if column.numeric else cell + space)
    return "| " + " | ".join(padded) + " |"


def _width(text: str) -> int:
    """Columns of a terminal: combining marks take none."""
    return sum(not unicodedata.combining(character) for character in text)


def _escaped(text: str) -> str:
    return text.replace("|", r"\|")
