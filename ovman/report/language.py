"""The tables of held-out sentences: how well they are understood, and what they are taken for."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.language import What
from ovman.analysis.rates import ALL
from ovman.report.cells import Record, number, p_value, percent, relation_columns, span
from ovman.report.table import DATA, PAGE, Column, Row, Table, Text, Words
from ovman.task import Relation

UNDERSTOOD, SUCCESS = "held-out sentences understood", "success of two visits (static gate)"
ROWS = {
    What.OBJECT: ("object", UNDERSTOOD),
    What.RELATION: ("relation", UNDERSTOOD),
    What.BOTH: ("object and relation", UNDERSTOOD),
    What.SUPPLIED: ("noun and relation supplied", SUCCESS),
    What.RELATION_INFERRED: ("noun supplied, relation inferred", SUCCESS),
    What.INFERRED: ("noun and relation inferred", SUCCESS),
}


def language_table(rates: Sequence[Record], confidence: float) -> Table:
    """Accuracies and success by relation, then what each relation was read as. rates: rows of "language.csv"."""
    by_what: dict[tuple[str, str], dict[str, Record]] = {}
    for rate in rates:
        by_what.setdefault((rate["what"], rate["read_as"]), {})[rate["relation"]] = rate
    n = {rate["relation"]: rate["n"] for rate in rates}
    origins = sorted({rate["origin"] for rate in rates})
    rows = [
        Row(_rates(*ROWS[What(what)], of_what), section=ROWS[What(what)][1])
        for (what, _), of_what in by_what.items()
        if what != What.READ_AS
    ]
    read_as = [(name, of_what) for (what, name), of_what in by_what.items() if what == What.READ_AS]
    order = [*map(str, Relation)]
    read_as.sort(key=lambda item: (order.index(item[0]) if item[0] in order else len(order), item[0]))
    rows += [Row(_counts(name, of_what, n), section="what sentences are read as (counts)") for name, of_what in read_as]
    return Table(
        name="language",
        caption=(
            "Held-out sentences, one an episode. A sentence that is not parsed has neither object nor relation right and is a "
            f"failure. The forms were {'; '.join(origins)}. Ranges are Wilson {percent(confidence)} intervals; gained and "
            "lost are the episodes that succeed unlike with noun and relation supplied, p of their exact McNemar test."
        ),
        columns=(
            Column("group", "group", formats=DATA),
            Column("what", "what"),
            *relation_columns(),
            *(
                Column(f"{relation}_{end}", f"{relation} {end}", numeric=True, formats=DATA)
                for relation in (*map(str, Relation), ALL)
                for end in ("low", "high")
            ),
            Column("range", percent(confidence), formats=PAGE),
            Column("n", "n", numeric=True),
            Column("wins", "gained", numeric=True),
            Column("losses", "lost", numeric=True),
            Column("p", "p", numeric=True),
        ),
        rows=tuple(rows),
        wide=True,
    )


def _rates(title: str, group: str, by_relation: dict[str, Record]) -> dict[str, Words]:
    cells: dict[str, Words] = {"group": group, "what": title}
    for relation, rate in by_relation.items():
        cells |= {
            relation: number(rate["rate"]),
            f"{relation}_low": number(rate["low"]),
            f"{relation}_high": number(rate["high"]),
        }
    whole = by_relation[ALL]
    cells |= {"range": span(whole["low"], whole["high"]), "n": whole["n"]}
    return cells | ({"wins": whole["wins"], "losses": whole["losses"], "p": p_value(whole["p"])} if whole["p"] else {})


def _counts(name: str, by_relation: dict[str, Record], n: dict[str, str]) -> dict[str, Words]:
    relations = {str(relation) for relation in Relation}
    title: Words = f"not parsed: {name.replace('_', ' ')}"
    if name in relations:
        title = Text(f"read as {name.upper()}", rf"read as \textsc{{{name}}}")
    counts = {relation: by_relation[relation]["count"] if relation in by_relation else "0" for relation in n}
    return {"group": "read as", "what": title, "n": n[ALL]} | counts
