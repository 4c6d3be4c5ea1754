"""The table of static success by number of instances of the category and by scene."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.comparisons import AGENT
from ovman.analysis.difficulty import By
from ovman.analysis.rates import Interval
from ovman.models.settings import Arm, Kind, of_kind
from ovman.report.cells import MARK, Record, number, percent, span
from ovman.report.table import CSV_AND_MARKDOWN, DATA, PAGE, Column, Row, Table

# What the paper's figure shows; the csv has all static arms.
TITLES = {AGENT: "two visits", "single_visit": "single visit", "grounding_two_visits": "grounding handed over"}
SECTIONS = {By.INSTANCES: "by instances of the category", By.SCENE: "by scene"}


def difficulty_table(rates: Sequence[Record], confidence: float, arms: Sequence[Arm]) -> Table:
    """Groups of episodes by arms. rates: rows of "difficulty.csv"; confidence: of the intervals."""
    there = {row["arm"] for row in rates}
    shown = [arm.name for arm in of_kind(arms, Kind.STATIC) if arm.name in there]
    cells: dict[tuple[str, str], dict[str, str]] = {}
    for row in rates:
        mark = MARK if row["interval"] == Interval.POISSON_BINOMIAL else ""
        cells.setdefault((row["by"], row["group"]), {"by": row["by"], "group": row["group"], "n": row["n"]}).update(
            {
                row["arm"]: number(row["rate"]),
                f"{row['arm']}_low": number(row["low"]),
                f"{row['arm']}_high": number(row["high"]),
            }
            | ({f"{row['arm']}_range": span(row["low"], row["high"]) + mark} if row["arm"] in TITLES else {})
        )
    return Table(
        name="difficulty",
        caption=(
            "Static success by the number of instances of the queried category and by scene. Ranges are Wilson "
            f"{percent(confidence)} intervals ({MARK} of an expectation: the Poisson-binomial range of one realised pass). "
            "Scenes have few episodes each: read the ranges."
        ),
        columns=(
            Column("by", "by", formats=CSV_AND_MARKDOWN),
            Column("group", "group"),
            Column("n", "n", numeric=True),
            *(column for arm in shown for column in _columns(arm, confidence)),
        ),
        rows=tuple(Row(of_group, section=SECTIONS[By(by)]) for (by, _), of_group in cells.items()),
        wide=True,
    )


def _columns(arm: str, confidence: float) -> tuple[Column, ...]:
    data = (
        Column(f"{arm}_low", f"{arm} low", numeric=True, formats=DATA),
        Column(f"{arm}_high", f"{arm} high", numeric=True, formats=DATA),
    )
    if arm not in TITLES:
        return (Column(arm, arm, numeric=True, formats=DATA), *data)
    return (Column(arm, TITLES[arm], numeric=True), *data, Column(f"{arm}_range", percent(confidence), formats=PAGE))
