"""The audit: what became of every candidate that was drawn, by relation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ovman.report.table import Column, Row, Table, Text
from ovman.task import Rejection, RejectionStage, Relation

DRAWN, CERTIFIED, RELEASED = "drawn", "certified", "released"
RELATIONS = tuple(relation.value for relation in Relation)


def rejections_table(counts: Sequence[Mapping[str, str]]) -> Table:
    """Stage, reason and the count of each relation; candidates drawn above, certified and released ones below.

    counts: rows (relation, stage, reason, count) of the audit; stage is one of Algorithm 1, or "drawn", "certified" or "released"
    without a reason. A reason that rejected nothing has no row.

    Raises ValueError for a relation, stage or reason that there is not, a line that is there twice, or a relation in which drawn
    is not rejected plus certified: an audit that does not add up is not printed.
    """
    table: dict[tuple[str, str], dict[str, int]] = {}
    for row in counts:
        line = table.setdefault((row["stage"], row["reason"]), {})
        if row["relation"] not in RELATIONS:
            raise ValueError(f"rejections: {row['relation']!r} is not a change relation")
        if row["relation"] in line:
            raise ValueError(f"rejections: {row['relation']}, {row['stage']} {row['reason']} is counted twice")
        line[row["relation"]] = int(row["count"])
    known = _lines()
    strangers = sorted(table.keys() - set(known))
    if strangers:
        raise ValueError(f"rejections: {' '.join(strangers[0]).strip()!r} is neither a stage with its reason nor a total")
    for relation in RELATIONS:
        _adds_up(relation, {line: of_line.get(relation, 0) for line, of_line in table.items()})
    totals = ((DRAWN, ""), (CERTIFIED, ""), (RELEASED, ""))
    return Table(
        name="rejections",
        caption="Audit of the candidates: first reason of rejection by relation, in the order of the checks.",
        columns=(
            Column("stage", "stage"),
            Column("reason", "reason"),
            *(Column(key, Text(key.upper(), rf"\textsc{{{key}}}"), numeric=True) for key in (*RELATIONS, "all")),
        ),
        rows=tuple(
            Row(
                {
                    "stage": stage,
                    **({"reason": reason} if reason else {}),
                    **{relation: str(of_line.get(relation, 0)) for relation in RELATIONS},
                    "all": str(sum(of_line.values())),
                }
            )
            for stage, reason in known
            if (of_line := table.get((stage, reason), {})) and (any(of_line.values()) or (stage, reason) in totals)
        ),
        wide=True,
    )


def _lines() -> list[tuple[str, str]]:
    """Every (stage, reason) that there can be, in the order in which they are printed."""
    reasons = [(reason.stage.value, reason.value) for stage in RejectionStage for reason in Rejection if reason.stage is stage]
    return [(DRAWN, ""), *reasons, (CERTIFIED, ""), (RELEASED, "")]


def _adds_up(relation: str, counts: Mapping[tuple[str, str], int]) -> None:
    drawn, certified, released = (counts.get((stage, ""), 0) for stage in (DRAWN, CERTIFIED, RELEASED))
    rejected = sum(count for (_, reason), count in counts.items() if reason)
    if drawn != rejected + certified:
        raise ValueError(f"rejections: {relation} has {drawn} drawn, but {rejected} rejected and {certified} certified")
    if released > certified:
        raise ValueError(f"rejections: {relation} has {released} released of {certified} certified")
