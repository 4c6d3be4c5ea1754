"""The table of an agent's own task beside this one."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.statistics import wilson_interval
from ovman.report.tables.columns import (
    arms_frame,
    exact_mean,
    interval_columns,
    numbers,
    p_values,
    percent,
    range_column,
    relation_column,
    signed,
    span,
    spread,
    spread_columns,
    words,
)
from ovman.report.tables.table import CSV_AND_MARKDOWN, SECTION, Table
from ovman.settings import Settings


def own_task_table(runs: pd.DataFrame, settings: Settings) -> Table:
    """One row an arm and relation, means over the seeds. runs: rows of `OwnTask`."""
    confidence, agents = settings.evaluation.confidence, arms_frame(settings)["system"]
    groups = runs.groupby(["arm", "relation"], sort=False)
    rows = [_row(agents[str(arm)], str(relation), seeds, confidence) for (arm, relation), seeds in groups]
    columns = (
        words("agent", formats=CSV_AND_MARKDOWN),
        relation_column(),
        *spread_columns("own", "own task"),
        *interval_columns("own"),
        range_column(confidence),
        *spread_columns("rate", "this task"),
        numbers("gap", data=signed),
        words("only_own", "only own"),
        words("only_here", "only this"),
        p_values("p", "p"),
        numbers("n"),
        numbers("seeds"),
    )
    caption = (
        "The same runs under two tests, means over the seeds (least and greatest of a seed). Own task: stopped with any instance "
        f"of the category within {settings.success.radius_m} m and in sight. This task: Eq. 4. Only own, only this: runs that "
        "succeed under one test alone, per seed. p: exact two-sided McNemar test on these, largest of the seeds. Ranges of the "
        f"own task: Wilson {percent(confidence)}, as wide as for one pass."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _row(agent: str, relation: str, seeds: pd.DataFrame, confidence: float) -> dict[str, object]:
    n = int(seeds["n"].iloc[0])
    low, high = wilson_interval(exact_mean(seeds["own_successes"]), n, confidence)
    return {
        SECTION: agent,
        "agent": agent,
        "relation": relation,
        **spread(seeds["own_rate"], "own"),
        "own_low": low,
        "own_high": high,
        "range": span(low, high),
        **spread(seeds["rate"], "rate"),
        "gap": exact_mean(seeds["gap"]),
        "only_own": ", ".join(map(str, seeds["only_own"])),
        "only_here": ", ".join(map(str, seeds["only_here"])),
        "p": seeds["p"].max(),
        "n": n,
        "seeds": len(seeds),
    }
