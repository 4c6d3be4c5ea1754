"""The table of controls: what a split can be solved with, beside the agents and chance."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.rates import Interval
from ovman.report.tables.columns import (
    ALL,
    MARK,
    RELATIONS,
    interval_columns,
    numbers,
    of_relation,
    range_column,
    span,
    three,
    words,
)
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Kind, Settings

CHANCE = {"chance": "1/n", "chance_of_change": "1/m"}
JUDGED = {Kind.STATIC: "static gate", Kind.EMBODIED: "driving"}


def controls_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """For each split, and on paper and driving, a row an agent, then a row a control, then the chances of 1/n and 1/m.

    rates: rows of `Controlled`.
    """
    blocks = [_block(of, settings) for _, of in rates.groupby(["split", "kind"], sort=False)]
    relations = (*RELATIONS, ALL)
    columns = (
        words("split"),
        words("judged"),
        words("what", ""),
        words("arm", formats=DATA),
        words("system"),
        words("memory"),
        *(column for relation in relations for column in (of_relation(relation, three), *interval_columns(relation))),
        range_column(settings.evaluation.confidence),
        numbers("spl", "SPL", three),
        numbers("n"),
    )
    caption = (
        "Controls lack something that the task is said to need. Where one comes near to an agent, the split does not measure "
        "what the control lacks. Chance: a random pick among the n instances of the category (mean of 1/n), or among the m "
        f"changes of the kind that defines the episode (mean of 1/m). {MARK} The expectation of a stochastic pick."
    )
    rows = pd.concat(blocks, ignore_index=True) if blocks else pd.DataFrame(columns=[column.key for column in columns])
    return Table(caption, columns, rows, wide=True)


def _block(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    split, kind = str(rates["split"].iloc[0]), Kind(rates["kind"].iloc[0])
    rows = [_row(str(arm), of_arm, settings) for arm, of_arm in rates.groupby("arm", sort=False)]
    rows.sort(key=lambda row: row["what"] == "control")
    relations = rates.drop_duplicates("relation").set_index("relation")
    n = rates.loc[rates["relation"] == ALL, "n"].max()
    rows += [{"what": "chance", "system": title, "n": n, **relations[column]} for column, title in CHANCE.items()]
    return pd.DataFrame(rows).assign(split=split, judged=JUDGED[kind], **{SECTION: f"{split}, {JUDGED[kind]}"})


def _row(arm: str, rates: pd.DataFrame, settings: Settings) -> dict[str, object]:
    entry = settings.arms[arm]
    row: dict[str, object] = {
        "what": "control" if rates["control"].iloc[0] else "agent",
        "arm": arm,
        "system": entry.system,
        "memory": entry.memory,
    }
    for one in rates.itertuples():
        row |= {str(one.relation): one.rate, f"{one.relation}_low": one.low, f"{one.relation}_high": one.high}
    over_all = rates[rates["relation"] == ALL].iloc[0]
    mark = MARK if over_all["interval"] == Interval.POISSON_BINOMIAL else ""
    return row | {"range": span(over_all["low"], over_all["high"], mark), "spl": over_all["spl"], "n": over_all["n"]}
