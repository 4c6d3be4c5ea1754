"""The table of an agent's own task beside this one."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ovman.analysis.statistics import wilson_interval
from ovman.models.settings import Arm, named
from ovman.report.cells import (
    Record,
    grouped,
    number,
    p_value,
    percent,
    signed,
    small_capitals,
    span,
    spread_cells,
    spread_columns,
)
from ovman.report.table import CSV_AND_MARKDOWN, DATA, PAGE, Column, Row, Table


def own_task_table(rows: Sequence[Record], radius_m: float, confidence: float, arms: Sequence[Arm]) -> Table:
    """One row an arm and relation, means over the seeds. rows: of "own_task.csv"; radius_m: R; confidence: of the intervals."""
    groups = grouped(rows, "arm", "relation")
    return Table(
        name="own_task",
        caption=(
            "The same runs under two tests. Own task: the agent stopped with any instance of the queried category within "
            f"{radius_m} m and in sight, as it was made to do. This task: Eq. 4, the instance or the place that the relation "
            "selects. Means over the seeds, in brackets the least and the greatest of a seed. Only own, only this: runs that "
            "succeed under one of the tests alone, of each seed in turn. p: exact two-sided McNemar test on these, the largest "
            f"of the seeds. Ranges are Wilson {percent(confidence)} intervals of the own task, as wide as for one pass."
        ),
        columns=(
            Column("agent", "agent", formats=CSV_AND_MARKDOWN),
            Column("relation", "relation"),
            *spread_columns("own", "own task"),
            Column("own_low", "own low", numeric=True, formats=DATA),
            Column("own_high", "own high", numeric=True, formats=DATA),
            Column("range", percent(confidence), formats=PAGE),
            *spread_columns("rate", "this task"),
            Column("gap", "gap", numeric=True),
            Column("only_own", "only own"),
            Column("only_here", "only this"),
            Column("p", "p", numeric=True, formats=DATA),
            Column("p_page", "p", numeric=True, formats=PAGE),
            Column("n", "n", numeric=True),
            Column("seeds", "seeds", numeric=True),
        ),
        rows=tuple(_row(named(arms, arm), relation, of_group, confidence) for (arm, relation), of_group in groups.items()),
        wide=True,
    )


def _row(arm: Arm, relation: str, rows: Sequence[Record], confidence: float) -> Row:
    def mean(key: str) -> float:
        return math.fsum(float(row[key]) for row in rows) / len(rows)

    low, high = wilson_interval(mean("own_successes"), int(rows[0]["n"]), confidence)
    cells = {
        "agent": arm.system,
        "relation": small_capitals(relation),
        "own_low": number(str(low)),
        "own_high": number(str(high)),
        "range": span(str(low), str(high)),
        "gap": signed(str(mean("gap"))),
        "only_own": ", ".join(row["only_own"] for row in rows),
        "only_here": ", ".join(row["only_here"] for row in rows),
        "p": (largest := max(rows, key=lambda row: float(row["p"]))["p"]),
        "p_page": p_value(largest),
        "n": rows[0]["n"],
        "seeds": str(len(rows)),
    }
    for key, column in (("own", "own_rate"), ("rate", "rate")):
        values = [float(row[column]) for row in rows]
        spread = spread_cells(key, values)
        cells |= spread if len(values) > 1 else spread | {f"{key}_page": spread[key]}
    return Row(cells, section=arm.system)
