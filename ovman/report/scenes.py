"""The table of success scene by scene, every arm."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.models.settings import Arm, Kind, named
from ovman.report.cells import Record, grouped, number
from ovman.report.table import CSV_AND_MARKDOWN, DATA, Column, Row, Table

SECTIONS = {Kind.STATIC: "static gate", Kind.EMBODIED: "embodied"}


def scenes_table(rates: Sequence[Record], arms: Sequence[Arm]) -> Table:
    """One row an arm: its worst and its best scene; the csv has every scene. rates: rows of "scenes.csv"."""
    names = list(dict.fromkeys(row["scene"] for row in rates))
    sizes = [int(row["n"]) for row in rates]
    return Table(
        name="scenes",
        caption=(
            "Success scene by scene, means over seeds or runs: of each arm the scene with the least and the one with the "
            "greatest rate, of equal ones the first, with its number of episodes, and in how many scenes the arm never succeeds. "
            + (f"A scene has {min(sizes)} to {max(sizes)} episodes: " if sizes else "")
            + "read the intervals of the metrics. The csv has every scene."
        ),
        columns=(
            Column("arm", "arm", formats=DATA),
            Column("system", "system"),
            Column("memory", "memory"),
            Column("grounding", "grounding", formats=CSV_AND_MARKDOWN),
            Column("positions", "positions", formats=CSV_AND_MARKDOWN),
            *(
                column
                for key, title in (("worst", "worst scene"), ("best", "best scene"))
                for column in (
                    Column(key, title),
                    Column(f"{key}_n", "n", numeric=True),
                    Column(f"{key}_rate", "rate", numeric=True),
                )
            ),
            Column("never", "scenes without success", numeric=True),
            Column("scenes", "scenes", numeric=True),
            *(Column(name, name, numeric=True, formats=DATA) for name in names),
        ),
        rows=tuple(_row(named(arms, arm), rows) for (arm,), rows in grouped(rates, "arm").items()),
        wide=True,
    )


def _row(arm: Arm, rows: Sequence[Record]) -> Row:
    cells = {
        "arm": arm.name,
        "system": arm.system,
        "memory": arm.memory,
        "grounding": arm.grounding.value,
        "positions": arm.positions.value,
        "never": str(sum(float(row["rate"]) == 0.0 for row in rows)),
        "scenes": str(len(rows)),
        **{row["scene"]: number(row["rate"]) for row in rows},
    }
    for key, choose in (("worst", min), ("best", max)):
        # Of equal ones the first.
        extreme = choose(rows, key=lambda row: float(row["rate"]))
        cells |= {key: extreme["scene"], f"{key}_n": extreme["n"], f"{key}_rate": number(extreme["rate"])}
    return Row(cells, section=SECTIONS[Kind(rows[0]["kind"])])
