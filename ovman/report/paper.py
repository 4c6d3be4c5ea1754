"""The paper's own figures, each with the place it is printed at, and how figures are written, ours and the paper's alike.

Section `paper` of the config says which arm stands next to which row. Only the page of results and the figures use them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

import yaml

EMPTY = "—"
SMALLEST_P = 1e-300
"""Below this a p value is written as a bound: it may have been rounded to zero."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Form(StrEnum):
    """How a figure is written: a rate, a difference of rates, a count, the expectation of one, a p value, or metres."""

    RATE = "rate"
    DIFFERENCE = "difference"
    COUNT = "count"
    EXPECTED = "expected"
    P = "p"
    METRES = "metres"


RATE, DIFFERENCE, COUNT, EXPECTED, P, METRES = Form


class Printed(NamedTuple):
    """A figure of the paper and where it is printed: a value, of which `low` and `high` are equal, or a range.

    A p value that is printed as a bound is the range from 0.
    """

    place: str
    low: float
    high: float

    def write(self, form: Form = RATE) -> str:
        """Return the figure in the form of ours next to it."""
        if self.low == self.high:
            return write(self.low, form)
        return f"{write(self.low, form)} – {write(self.high, form)}" if self.low else f"< {_write_power(self.high)}"


def write(value: float, form: Form = RATE) -> str:
    """Write rates with three decimals, differences with a sign, small p values as powers of ten, metres with their unit."""
    match form:
        case Form.RATE:
            return f"{value:.3f}"
        case Form.DIFFERENCE:
            text = f"{value:+.3f}"
            return text.replace("-", "−") if float(text) else "0.000"
        case Form.COUNT:
            return f"{value:.0f}"
        case Form.EXPECTED:
            return f"{value:.1f}"
        case Form.METRES:
            return f"{value:.1f} m" if value >= 10 else f"{value:.2f} m"
        case Form.P:
            return write_p(value)


def write_p(p: float) -> str:
    """Write 0.032 as it is, 0.00043 as 4.3 × 10⁻⁴, and 0 as a bound."""
    if p < SMALLEST_P:
        return f"< {_write_power(SMALLEST_P)}"
    return f"{p:.3f}" if p >= 0.001 else _write_power(p)


def _write_power(p: float) -> str:
    mantissa, exponent = f"{p:.1e}".replace(".0e", "e").split("e")
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    return power if mantissa == "1" else f"{mantissa} × {power}"


COLUMNS = ("moved", "former", "moving", "stable", "appeared", "removed", "all", "spl")
"""Columns of the paper's tables; a shorter row lacks the last ones."""
TITLES = {
    "static.one": "one visit",
    "static.two": "two visits",
    "static.grounding_one": "one visit, oracle grounding",
    "static.grounding_two": "two visits, oracle grounding",
    "static.positions_one": "one visit, oracle positions",
    "static.positions_two": "two visits, oracle positions",
    "embodied.one": "one visit",
    "embodied.two": "two visits",
    "embodied.positions_two": "two visits, true positions",
    "embodied.oracle": "oracle",
    "taxonomy.success": "success",
    "taxonomy.abstain": "abstained (no candidate)",
    "taxonomy.elsewhere": "elsewhere (> 2 m)",
    "taxonomy.near_miss": "near miss (1–2 m)",
    "taxonomy.wrong_instance": "wrong instance",
    "taxonomy.episodes": "episodes",
    "taxonomy.lost_in_navigation": "lost in navigation, first seed †",
}
"""Titles of rows; a row without one has the title of the arm that stands next to it."""

_FIGURES: Mapping[str, Any] = yaml.safe_load(Path(__file__).with_name("paper.yaml").read_text(encoding="utf-8"))
TABLES: Mapping[str, Mapping[str, Sequence[float]]] = _FIGURES["tables"]
"""Table, row and cells. The key of a cell is "static.two.all"."""
PAPER: Mapping[str, Printed] = {
    f"{table}.{row}.{column}": Printed(f'Table "{table}"', value, value)
    for table, rows in TABLES.items()
    for row, cells in rows.items()
    for column, value in zip(COLUMNS, cells, strict=False)
} | {
    key: Printed(place, *(value if isinstance(value, list) else [value, value]))
    for place, entries in _FIGURES["text"].items()
    for key, value in entries.items()
}
"""All figures by key: "static.two.all" of a table, "parser_accuracy" of the text."""
