r"""A table as LaTeX with booktabs rules, to be \input into a document that loads booktabs."""

from __future__ import annotations

from ovman.report.table import Format, Table, Text, Words

EMPTY = "---"

_SPECIAL = {
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


def latex(table: Table) -> str:
    """A floating table: caption, label, and one tabular; a heading over all columns starts each section of rows."""
    columns = table.columns_in(Format.LATEX)
    environment = "table*" if table.wide else "table"
    lines = [
        rf"\begin{{{environment}}}[t]\centering\small",
        rf"\caption{{{tex(table.caption)}}}\label{{tab:{table.name}}}",
        rf"\begin{{tabular}}{{{''.join('r' if column.numeric else 'l' for column in columns)}}}",
        r"\toprule",
        _row([tex(column.title) for column in columns]),
        r"\midrule",
    ]
    section = None
    for index, row in enumerate(table.rows):
        if row.section != section:
            section = row.section
            if index:
                lines.append(r"\midrule")
            if section:
                lines.append(rf"\multicolumn{{{len(columns)}}}{{l}}{{\emph{{{escaped(section)}}}}} \\")
        lines.append(_row([tex(row.cells.get(column.key, "")) or EMPTY for column in columns]))
    lines += [r"\bottomrule", r"\end{tabular}", rf"\end{{{environment}}}"]
    return "\n".join(lines) + "\n"


def tex(words: Words) -> str:
    """LaTeX source of words; plain ones are escaped."""
    return words.tex if isinstance(words, Text) else escaped(words)


def escaped(text: str) -> str:
    """LaTeX source that sets this very text.

    Raises ValueError for a character that plain pdfLaTeX with its default encoding may not have.
    """
    source = "".join(_SPECIAL.get(character, character) for character in text)
    strangers = sorted({character for character in source if not character.isascii()})
    if strangers:
        raise ValueError(f"no LaTeX for {', '.join(strangers)} in {text!r}; give it as Text(plain, tex)")
    return source


def _row(cells: list[str]) -> str:
    return " & ".join(cells) + r" \\"
