"""The table of how far apart the seeds of an arm lie."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ovman.analysis.rates import ALL
from ovman.models.settings import Arm, Kind, named
from ovman.report.cells import RELATIONS, Record, grouped, number, small_capitals
from ovman.report.table import CSV_AND_MARKDOWN, DATA, PAGE, Column, Row, Table

SECTIONS = {Kind.STATIC: "static gate, by run", Kind.EMBODIED: "embodied, by seed"}


def seeds_table(passes: Sequence[Record], arms: Sequence[Arm]) -> Table:
    """One row an arm. passes: rows of "seeds.csv"."""
    return Table(
        name="seeds",
        caption=(
            "Success under each seed, and for static arms that answer otherwise each time they run, in each run: the same "
            "episodes every time. Relations: from the least to the greatest of a seed. Spread: the greatest of all minus the "
            "least. All other static arms answer the same under every seed."
        ),
        columns=(
            Column("arm", "arm", formats=DATA),
            Column("system", "system"),
            Column("memory", "memory"),
            Column("grounding", "grounding", formats=CSV_AND_MARKDOWN),
            *(column for relation in RELATIONS for column in _columns(relation)),
            Column("each", "each seed"),
            Column("mean", "mean", numeric=True),
            Column("all_min", "all least", numeric=True, formats=DATA),
            Column("all_max", "all greatest", numeric=True, formats=DATA),
            Column("spread", "spread", numeric=True),
            Column("n", "n", numeric=True),
        ),
        rows=tuple(_row(named(arms, arm), rows) for (arm,), rows in grouped(passes, "arm").items()),
        wide=True,
    )


def _columns(relation: str) -> tuple[Column, ...]:
    return (
        Column(f"{relation}_min", f"{relation} least", numeric=True, formats=DATA),
        Column(f"{relation}_max", f"{relation} greatest", numeric=True, formats=DATA),
        Column(relation, small_capitals(relation), formats=PAGE),
    )


def _row(arm: Arm, rows: Sequence[Record]) -> Row:
    cells = {"arm": arm.name, "system": arm.system, "memory": arm.memory, "grounding": arm.grounding.value}
    for relation in (*RELATIONS, ALL):
        of_relation = [row for row in rows if row["relation"] == relation]
        if not of_relation:
            continue
        rates = [float(row["rate"]) for row in of_relation]
        least, greatest = number(str(min(rates))), number(str(max(rates)))
        cells |= {f"{relation}_min": least, f"{relation}_max": greatest}
        if relation == ALL:
            cells |= {
                "each": ", ".join(number(row["rate"]) for row in of_relation),
                "mean": number(str(math.fsum(rates) / len(rates))),
                "spread": number(str(max(rates) - min(rates))),
                "n": of_relation[0]["n"],
            }
        else:
            cells[relation] = f"{least}–{greatest}"
    return Row(cells, section=SECTIONS[Kind(rows[0]["kind"])])
