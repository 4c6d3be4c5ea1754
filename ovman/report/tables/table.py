"""Tables: how one is made from rows of metrics, and its three forms, csv, Markdown and LaTeX, all written by pandas."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, cast

import pandas as pd

from ovman.analysis.rows import Row
from ovman.settings import Kind, Settings

ALL = "all"
CONTROLS = "controls"
"""The section of arms that are not systems. Markdown sets a heading above it, too."""
EMPTY, EMPTY_TEX = "—", "---"
CAPTION_WIDTH = 132


Format = Literal["csv", "md", "tex"]
EVERYWHERE: tuple[Format, ...] = ("csv", "md", "tex")
DATA: tuple[Format, ...] = ("csv",)
PAGE: tuple[Format, ...] = ("md", "tex")
CSV_AND_MARKDOWN: tuple[Format, ...] = ("csv", "md")

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


def escape_latex(text: str) -> str:
    """Return LaTeX source that sets this text. ValueError for a character that plain pdfLaTeX does not have."""
    source = text.translate(_SPECIAL)
    if strangers := sorted({character for character in source if not character.isascii()}):
        raise ValueError(f"no LaTeX for {', '.join(strangers)} in {text!r}; give the column a `tex` of its own")
    return source


@dataclass(frozen=True, slots=True)
class Group:
    """The rows of metrics that make one row of a table."""

    rows: Sequence[Mapping[str, Any]]
    settings: Settings

    def get(self, name: str) -> Any:
        """Return the value of a column over all relations, or in the first row if no row is over all; None if it is absent."""
        whole = next((row for row in self.rows if row.get("relation") == ALL), self.rows[0] if self.rows else {})
        return None if pd.isna(value := whole.get(name)) else value

    def values(self, name: str) -> list[Any]:
        """Return the values of a column that are there."""
        return [row[name] for row in self.rows if not pd.isna(row[name])]

    def where(self, **values: str) -> Group:
        """Return the rows that have these values."""
        rows = [row for row in self.rows if all(row.get(name) == value for name, value in values.items())]
        return Group(rows, self.settings)


Value = Callable[[Group], Any]


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table. key: its header in the csv; title: on a page.

    Attributes:
        value: Computes the cell of a group; `Group.get` of the key if not given.
        data: How the csv writes a value that is there.
        page: How a page writes it; like the csv if not given.
        tex: LaTeX source of what a page writes.
        title_tex: LaTeX source of the title.
        numeric: Whether the column is aligned to the right.
        formats: Where the column is written.
    """

    key: str
    title: str
    value: Value | None = None
    data: Callable[[Any], str] = str
    page: Callable[[Any], str] | None = None
    tex: Callable[[str], str] = escape_latex
    title_tex: str | None = None
    numeric: bool = False
    formats: tuple[Format, ...] = EVERYWHERE

    def texts(self, groups: Sequence[Group], form: Format) -> list[str]:
        """Return the cells in one format; an absent value is empty in the csv and a dash on a page."""
        write = self.data if form == "csv" or self.page is None else self.page
        values = [group.get(self.key) if self.value is None else self.value(group) for group in groups]
        texts = ["" if value is None or value == "" else write(value) for value in values]
        if form == "md":
            return [text.replace("|", r"\|") or EMPTY for text in texts]
        return texts if form == "csv" else [self.tex(text) if text else EMPTY_TEX for text in texts]


@dataclass(frozen=True)
class Table:
    """A table with one group per row.

    Attributes:
        sections: One per row. LaTeX sets a rule and a heading above each run of equal ones; a blank one has no heading.
        wide: Whether LaTeX sets it across both columns of a page.
    """

    caption: str
    columns: tuple[Column, ...]
    groups: tuple[Group, ...]
    sections: tuple[str, ...] = ()
    wide: bool = False

    def __post_init__(self) -> None:
        """Check that keys differ."""
        keys = [column.key for column in self.columns]
        if twice := {key for key in keys if keys.count(key) > 1}:
            raise ValueError(f"two columns of a table are called {twice.pop()}; rename one")

    def cells(self, form: Format) -> pd.DataFrame:
        """Return the text of every cell that a format shows, by key."""
        texts = {column.key: column.texts(self.groups, form) for column in self.columns_in(form)}
        return pd.DataFrame({key: pd.Series(cells, dtype=object) for key, cells in texts.items()})

    def columns_in(self, form: Format) -> tuple[Column, ...]:
        """Return the columns that a format shows."""
        return tuple(column for column in self.columns if form in column.formats)


def csv_text(table: Table) -> str:
    """Format a table as csv; headers are the columns' keys."""
    return table.cells("csv").to_csv(index=False, lineterminator="\n")


def markdown(table: Table) -> str:
    """Format the caption, an empty line and the table."""
    caption = textwrap.wrap(table.caption, CAPTION_WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join([*caption, ""]) + "\n" + markdown_body(table)


def markdown_body(table: Table) -> str:
    """Format a table without its caption, with a line feed at the end."""
    columns, body = table.columns_in("md"), table.cells("md").to_numpy().tolist()
    if CONTROLS in table.sections:
        body.insert(table.sections.index(CONTROLS), [f"*{CONTROLS}*", *[""] * (len(columns) - 1)])
    return pipe_table([column.title for column in columns], body, [column.numeric for column in columns])


def pipe_table(header: Sequence[str], body: Sequence[Sequence[str]], numeric: Sequence[bool]) -> str:
    """Format a Markdown table, with a line feed at the end; `numeric` columns are aligned to the right."""
    frame = pd.DataFrame(list(body), columns=list(header), dtype=object)
    align = ["right" if right else "left" for right in numeric]
    return f"{frame.to_markdown(index=False, tablefmt='pipe', colalign=align if len(frame) else None, disable_numparse=True)}\n"


def latex(table: Table, name: str) -> str:
    r"""Format a floating table with booktabs rules, to be \input; `name`: of its label."""
    columns, cells = table.columns_in("tex"), table.cells("tex")
    cells.columns = pd.Index([column.title_tex or escape_latex(column.title) for column in columns])
    text = cells.style.hide(axis="index").to_latex(
        column_format="".join("r" if column.numeric else "l" for column in columns),
        position="t",
        position_float="centering",
        hrules=True,
        label=f"tab:{name}",
        caption=escape_latex(table.caption),
        environment="table*" if table.wide else "table",
    )
    return _with_headings(text, table.sections, len(columns))


def _with_headings(text: str, sections: Sequence[str], columns: int) -> str:
    head, rule, body = text.partition("\\midrule\n")
    lines = body.splitlines(keepends=True)
    made = []
    for index, (section, line) in enumerate(zip(sections, lines, strict=False)):
        if index == 0 or section != sections[index - 1]:
            made += [rule] if index else []
            made += [rf"\multicolumn{{{columns}}}{{l}}{{\emph{{{escape_latex(section)}}}}} \\" + "\n"] if section.strip() else []
        made.append(line)
    return head + rule + "".join([*made, *lines[len(sections) :]])


def percent(share: float) -> str:
    """Write a share in per cent."""
    return f"{100 * share:.6g} %"


Rows = Callable[[pd.DataFrame, Settings], pd.DataFrame]


@dataclass(frozen=True)
class TableSpec:
    """A table of metrics.

    Attributes:
        caption: In words, or a function of the metrics and the settings. `{s.success.radius_m}` is a constant of the settings and
            `{confidence}` the confidence of intervals in per cent.
        columns: In their order, or a function that makes them.
        by: The columns of the metrics that rows are grouped by; each group is a row of the table. Without any, each row is one.
        rows: Filters, orders or completes the metrics before they are grouped.
        section: The heading above the rows of a group in LaTeX.
        wide: Whether LaTeX sets the table across both columns of a page.
        kind: The kind of arms of which the table has one row each, for notes on arms that were not run.
    """

    caption: str | Callable[[pd.DataFrame, Settings], str]
    columns: tuple[Column, ...] | Callable[[pd.DataFrame, Settings], tuple[Column, ...]]
    by: tuple[str, ...] = ()
    rows: Rows = lambda metrics, settings: metrics
    section: Value = lambda group: ""
    wide: bool = True
    kind: Kind | None = None


def make_table(spec: TableSpec, metrics: pd.DataFrame, settings: Settings) -> Table:
    """Make a table of rows of metrics. ValueError if the rows contradict themselves."""
    rows = spec.rows(metrics, settings)
    keys = [rows[name] for name in spec.by] or [pd.Series(range(len(rows)), index=rows.index)]
    parts = [part for _, part in rows.groupby(keys, sort=False, dropna=False)] if len(rows) else []
    groups = tuple(Group(cast(list[Row], part.to_dict("records")), settings) for part in parts)
    named = {"s": settings, "confidence": percent(settings.evaluation.confidence)}
    caption = spec.caption if isinstance(spec.caption, str) else spec.caption(metrics, settings)
    columns = spec.columns if isinstance(spec.columns, tuple) else spec.columns(metrics, settings)
    return Table(
        caption.format(**named),
        tuple(replace(column, title=column.title.format(**named)) for column in columns),
        groups,
        tuple(str(spec.section(group)) for group in groups),
        spec.wide,
    )


def read_metrics(path: Path) -> pd.DataFrame:
    """Read a csv file of metrics: whole numbers, other numbers and words by their looks; empty is NaN or NA, in words ""."""
    return type_metrics(pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8"))


def type_metrics(text: pd.DataFrame) -> pd.DataFrame:
    """Type the columns of metrics that were read as text."""
    return pd.DataFrame({name: _typed(text[name]) for name in text.columns})


def _typed(column: pd.Series[str]) -> pd.Series[Any]:
    there = column[column != ""]
    if there.str.fullmatch(r"-?\d+").all():
        return pd.to_numeric(column.where(column != "", None)).astype("int64" if len(there) == len(column) else "Int64")
    numbers = pd.to_numeric(there, errors="coerce")
    return column if numbers.isna().any() else numbers.astype("float64").reindex(column.index)
