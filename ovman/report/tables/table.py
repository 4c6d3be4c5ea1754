"""A table before it is written, and its three forms: csv, Markdown and LaTeX, all written by pandas."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import pandas as pd

SECTION = "section"
"""Column of a table's rows that names the heading above them in LaTeX; blank for a rule without a heading."""
CONTROLS = "controls"
"""The section of arms that are no systems. Markdown sets a heading above it, too: nobody must take one for a system."""
EMPTY, EMPTY_TEX = "—", "---"
CAPTION_WIDTH = 132


class Format(Enum):
    """Where a column is written."""

    CSV = "csv"
    MARKDOWN = "md"
    LATEX = "tex"


EVERYWHERE = frozenset(Format)
DATA = frozenset({Format.CSV})
PAGE = frozenset({Format.MARKDOWN, Format.LATEX})
CSV_AND_MARKDOWN = frozenset({Format.CSV, Format.MARKDOWN})

_SPECIAL = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "{": r"\{",
        "}": r"\}",
        "$": r"\$",
        "&": r"\&",
        "#": r"\#",
        "%": r"\%",
        "_": r"\_",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "–": "--",
        "—": "---",
        "°": r"$^\circ$",
        "†": r"$^\dagger$",
        "≥": r"$\ge$",
        "×": r"$\times$",
    }
)


def escaped(text: str) -> str:
    """LaTeX source that sets this very text. Raises ValueError for a character that plain pdfLaTeX may not have."""
    source = text.translate(_SPECIAL)
    strangers = sorted({character for character in source if not character.isascii()})
    if strangers:
        raise ValueError(f"no LaTeX for {', '.join(strangers)} in {text!r}; give the column a `tex` of its own")
    return source


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    key: its header in the csv, and its column in the rows. title: its header on a page. data, page: how the csv and a page write
    a value that is there; page as data if it is not given. tex, title_tex: LaTeX source of what a page writes. numeric: aligned
    to the right. formats: where the column is written.
    """

    key: str
    title: str
    data: Callable[[Any], str] = str
    page: Callable[[Any], str] | None = None
    tex: Callable[[str], str] = escaped
    title_tex: str | None = None
    numeric: bool = False
    formats: frozenset[Format] = EVERYWHERE

    def texts(self, rows: pd.DataFrame, form: Format) -> list[str]:
        """The cells of the column in one format; an absent value is empty in the csv and a dash on a page."""
        write = self.data if form is Format.CSV or self.page is None else self.page
        values = rows[self.key].tolist() if self.key in rows else [None] * len(rows)
        texts = ["" if pd.isna(value) or value == "" else write(value) for value in values]
        if form is Format.MARKDOWN:
            return [text.replace("|", r"\|") or EMPTY for text in texts]
        return texts if form is Format.CSV else [self.tex(text) if text else EMPTY_TEX for text in texts]


@dataclass(frozen=True)
class Table:
    """A table. caption: in words. rows: a column of values for each of `columns`, absent ones are empty; with a column `SECTION`
    LaTeX sets a heading above each run of rows that have the same. wide: LaTeX sets it across both columns of a page.

    Raises ValueError where two columns have one key, or where a column of the rows has no column of the table.
    """

    caption: str
    columns: tuple[Column, ...]
    rows: pd.DataFrame = field(compare=False)
    wide: bool = False

    def __post_init__(self) -> None:
        keys = [column.key for column in self.columns]
        if len(set(keys)) < len(keys):
            raise ValueError("two columns of a table have one key")
        if strangers := sorted(set(self.rows.columns) - {*keys, SECTION}):
            raise ValueError(f"no column of the table for {', '.join(strangers)}")

    def cells(self, form: Format) -> pd.DataFrame:
        """The text of every cell that a format shows, a column each, in order."""
        shown = self.columns_in(form)
        return pd.DataFrame({column.key: pd.Series(column.texts(self.rows, form), dtype=object) for column in shown})

    def columns_in(self, form: Format) -> tuple[Column, ...]:
        """The columns that a format shows."""
        return tuple(column for column in self.columns if form in column.formats)


def csv_text(table: Table) -> str:
    """RFC 4180 with a line feed at each end of line; headers are the columns' keys."""
    return table.cells(Format.CSV).to_csv(index=False, lineterminator="\n")


def markdown(table: Table) -> str:
    """The caption, an empty line, the table, and a line feed at the end."""
    caption = textwrap.wrap(table.caption, CAPTION_WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join([*caption, ""]) + "\n" + markdown_body(table)


def markdown_body(table: Table) -> str:
    """The table without its caption, with a line feed at the end."""
    columns, body = table.columns_in(Format.MARKDOWN), table.cells(Format.MARKDOWN).to_numpy().tolist()
    if SECTION in table.rows and CONTROLS in (sections := table.rows[SECTION].tolist()):
        body.insert(sections.index(CONTROLS), [f"*{CONTROLS}*", *[""] * (len(columns) - 1)])
    return pipe_table([column.title for column in columns], body, [column.numeric for column in columns])


def pipe_table(header: Sequence[str], body: Sequence[Sequence[str]], numeric: Sequence[bool]) -> str:
    """A Markdown table alone, with a line feed at the end; `numeric` columns are aligned to the right."""
    frame = pd.DataFrame(list(body), columns=list(header), dtype=object)
    align = ["right" if right else "left" for right in numeric]
    return f"{frame.to_markdown(index=False, tablefmt='pipe', colalign=align if len(frame) else None, disable_numparse=True)}\n"


def latex(table: Table, name: str) -> str:
    r"""A floating table with booktabs rules, to be \input into a document that loads booktabs; `name`: of its label."""
    columns, cells = table.columns_in(Format.LATEX), table.cells(Format.LATEX)
    cells.columns = pd.Index([column.title_tex or escaped(column.title) for column in columns])
    text = cells.style.hide(axis="index").to_latex(
        column_format="".join("r" if column.numeric else "l" for column in columns),
        position="t",
        position_float="centering",
        hrules=True,
        label=f"tab:{name}",
        caption=escaped(table.caption),
        environment="table*" if table.wide else "table",
    )
    return _with_headings(text, table.rows[SECTION].tolist(), len(columns)) if SECTION in table.rows else text


def _with_headings(text: str, sections: Sequence[str], columns: int) -> str:
    """LaTeX of a table with a rule and a heading above each run of rows of one section."""
    head, rule, body = text.partition("\\midrule\n")
    lines = body.splitlines(keepends=True)
    made = []
    for index, (section, line) in enumerate(zip(sections, lines, strict=False)):
        if index == 0 or section != sections[index - 1]:
            made += [rule] if index else []
            made += [rf"\multicolumn{{{columns}}}{{l}}{{\emph{{{escaped(section)}}}}} \\" + "\n"] if section.strip() else []
        made.append(line)
    return head + rule + "".join([*made, *lines[len(sections) :]])
