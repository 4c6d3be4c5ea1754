"""The table of failures of the two-visit agent."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.comparisons import AGENT
from ovman.analysis.taxonomy import LOST, Verdict
from ovman.report.cells import Record, relation_columns
from ovman.report.table import Column, Row, Table

TITLES = {
    Verdict.SUCCESS: "success",
    Verdict.ABSTAIN: "abstain",
    Verdict.ELSEWHERE: "elsewhere",
    Verdict.NEAR_MISS: "near miss",
    Verdict.WRONG_INSTANCE: "wrong instance",
}


def taxonomy_table(counts: Sequence[Record], radius_m: float, near_miss_m: float) -> Table:
    """How the two-visit agent fails. counts: rows of "taxonomy.csv"; radius_m: R; near_miss_m: as in config.yaml.

    Raises ValueError where the verdicts of a relation do not add up to its episodes.
    """
    ours = [row for row in counts if row["arm"] == AGENT]
    of_verdict = {which: {r["relation"]: int(r["episodes"]) for r in ours if r["verdict"] == which} for which in Verdict}
    episodes = {row["relation"]: int(row["n"]) for row in ours}
    for relation, n in episodes.items():
        total = sum(of_verdict[which].get(relation, 0) for which in Verdict)
        if total != n:
            raise ValueError(f"the verdicts on {relation} add up to {total} of {n} episodes; make the metrics again")
    lost: dict[str, dict[str, int]] = {}
    for row in ours:
        if row["verdict"] == LOST:
            lost.setdefault(row["seed"], {})[row["relation"]] = int(row["episodes"])
    rows = [_row(title, of_verdict[which]) for which, title in TITLES.items()] if ours else []
    rows += [_row("episodes", episodes, section="")] if ours else []
    rows += [_row("lost in navigation", of_seed, section="of success, no sixth outcome") for of_seed in list(lost.values())[:1]]
    return Table(name="taxonomy", caption=_caption(episodes, lost, radius_m, near_miss_m), columns=_COLUMNS, rows=tuple(rows))


_COLUMNS = (Column("outcome", "outcome"), *relation_columns())


def _row(title: str, cells: dict[str, int], section: str | None = None) -> Row:
    return Row({"outcome": title, **{relation: str(count) for relation, count in cells.items()}}, section)


def _caption(episodes: dict[str, int], lost: dict[str, dict[str, int]], radius_m: float, near_miss_m: float) -> str:
    caption = (
        f"How the two-visit agent fails (static gate). Wrong instance: a failed prediction within {radius_m} m of where another "
        "instance of the category was recorded in the visit that the answer belongs to, however near the answer is. Near miss: "
        f"any other failed prediction up to {near_miss_m} m from the answer; elsewhere: one that is farther."
    )
    if episodes:
        caption += f" The first five rows partition the {episodes['all']} episodes."
    if lost:
        first, *others = lost
        caption += (
            " Lost in navigation, a subset of success: static successes that fail when executed once, under seed "
            f"{first}{_others(others, lost)}."
        )
    return caption


def _others(seeds: list[str], lost: dict[str, dict[str, int]]) -> str:
    totals = ", ".join(f"{lost[seed]['all']} under seed {seed}" for seed in seeds)
    return f" (in all {totals})" if seeds else ""
