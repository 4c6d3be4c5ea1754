"""The table of held-out sentences: how well they are understood, and what they are taken for."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.language import What
from ovman.report.tables.columns import (
    ALL,
    RELATIONS,
    count,
    interval_columns,
    numbers,
    of_relation,
    p_value,
    percent,
    power_of_ten,
    range_column,
    small_capitals,
    span,
    three,
    words,
)
from ovman.report.tables.table import DATA, SECTION, Column, Table
from ovman.settings import Settings

UNDERSTOOD, SUCCESS, READ_AS = "held-out sentences understood", "success of two visits (static gate)", "read as"
ROWS = {
    What.OBJECT: ("object", UNDERSTOOD),
    What.RELATION: ("relation", UNDERSTOOD),
    What.BOTH: ("object and relation", UNDERSTOOD),
    What.SUPPLIED: ("noun and relation supplied", SUCCESS),
    What.RELATION_INFERRED: ("noun supplied, relation inferred", SUCCESS),
    What.NOUN_INFERRED: ("noun inferred, relation supplied", SUCCESS),
    What.INFERRED: ("noun and relation inferred", SUCCESS),
}


def language_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """Accuracies and success by relation, then what each relation was read as. rates: rows of `LanguageRate`."""
    counted = rates["what"] == What.READ_AS
    measured = [_rates(What(str(what)), of_what) for what, of_what in rates[~counted].groupby("what", sort=False)]
    n = rates.drop_duplicates("relation").set_index("relation")["n"]
    read_as = {str(name): of_name.set_index("relation")["count"] for name, of_name in rates[counted].groupby("read_as")}
    names = sorted(read_as, key=lambda name: (RELATIONS.index(name) if name in RELATIONS else len(RELATIONS), name))
    rows = [*measured, *(_counts(name, read_as[name], n) for name in names)]
    confidence = settings.evaluation.confidence
    columns = (
        words("group", formats=DATA),
        words("what", tex=small_capitals),
        *(of_relation(relation, _rate_or_count) for relation in (*RELATIONS, ALL)),
        *(column for relation in (*RELATIONS, ALL) for column in interval_columns(relation)),
        range_column(confidence),
        numbers("n"),
        numbers("wins", "gained", count),
        numbers("losses", "lost", count),
        Column("p", "p", p_value, tex=power_of_ten, numeric=True),
    )
    caption = (
        "Held-out sentences, one an episode. A sentence that is not parsed has neither object nor relation right and is a "
        f"failure. The forms were {'; '.join(sorted({*rates['origin']}))}. Ranges are Wilson {percent(confidence)} intervals; "
        "gained and lost are the episodes whose success differs from that with noun and relation supplied, p of their exact "
        "McNemar test."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _rates(what: What, rates: pd.DataFrame) -> dict[str, object]:
    title, group = ROWS[what]
    row: dict[str, object] = {SECTION: group, "group": group, "what": title}
    for rate in rates.itertuples():
        row |= {f"{rate.relation}": rate.rate, f"{rate.relation}_low": rate.low, f"{rate.relation}_high": rate.high}
    whole = rates[rates["relation"] == ALL].iloc[0]
    row |= {"range": span(whole["low"], whole["high"]), "n": str(whole["n"])}
    return row | {key: whole[key] for key in ("wins", "losses", "p") if pd.notna(whole["p"])}


def _counts(name: str, counts: pd.Series[int], n: pd.Series[int]) -> dict[str, object]:
    title = f"read as {name.upper()}" if name in RELATIONS else f"not parsed: {name.replace('_', ' ')}"
    row: dict[str, object] = {SECTION: "what sentences are read as (counts)", "group": READ_AS, "what": title, "n": str(n[ALL])}
    return row | {str(relation): str(counts.get(relation, 0)) for relation in n.index}


def _rate_or_count(value: float | str) -> str:
    return value if isinstance(value, str) else three(value)
