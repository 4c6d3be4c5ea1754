"""The audit: what became of every candidate that was drawn, by relation."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from ovman.generation.audit import CERTIFIED, DRAWN, RELEASED
from ovman.records.task import Rejection, RejectionStage
from ovman.report.tables.columns import ALL, RELATIONS, of_relation, words
from ovman.report.tables.table import Table
from ovman.settings import Settings

TOTALS = (DRAWN, CERTIFIED, RELEASED)
"""Stages without a reason."""


@dataclass(frozen=True, slots=True)
class RejectionCount:
    """How many candidates of a relation were rejected for a reason of a stage of Algorithm 1, or are in one of the totals."""

    relation: str
    stage: str
    reason: str
    count: int


def rejections_table(counts: pd.DataFrame, settings: Settings) -> Table:
    """Stage, reason and the count of each relation; candidates drawn above, certified and released ones below.

    counts: rows of `RejectionCount`. A reason that rejected nothing has no row.

    Raises ValueError for a relation, stage or reason that does not exist, a line that occurs twice, or a relation in which drawn
    is not rejected plus certified: an audit that does not add up is not printed.
    """
    for wrong in counts.loc[~counts["relation"].isin(RELATIONS), "relation"]:
        raise ValueError(f"rejections: {wrong!r} is not a change relation")
    for row in counts[counts.duplicated(["relation", "stage", "reason"])].itertuples():
        raise ValueError(f"rejections: {row.relation}, {row.stage} {row.reason} is counted twice")
    table = counts.pivot(index=["stage", "reason"], columns="relation", values="count").fillna(0).astype(int)
    known = _lines()
    if strangers := sorted({*table.index} - {*known}):
        raise ValueError(f"rejections: {' '.join(strangers[0]).strip()!r} is neither a stage with its reason nor a total")
    table = table.reindex(index=pd.MultiIndex.from_tuples(known, names=table.index.names), columns=RELATIONS, fill_value=0)
    for relation in RELATIONS:
        _adds_up(relation, table[relation])
    table[ALL] = table.sum(axis=1)
    shown = table[(table[ALL] > 0) | table.index.get_level_values("stage").isin(TOTALS)]
    columns = (words("stage"), words("reason"), *(of_relation(relation) for relation in (*RELATIONS, ALL)))
    caption = "Audit of the candidates: first reason of rejection by relation, in the order of the checks."
    return Table(caption, columns, shown.reset_index(), wide=True)


def _lines() -> list[tuple[str, str]]:
    """Every (stage, reason) that is possible, in the order in which they are printed."""
    reasons = [(reason.stage.value, reason.value) for stage in RejectionStage for reason in Rejection if reason.stage is stage]
    return [(DRAWN, ""), *reasons, (CERTIFIED, ""), (RELEASED, "")]


def _adds_up(relation: str, counts: pd.Series[int]) -> None:
    drawn, certified, released = (int(counts[stage, ""]) for stage in TOTALS)
    rejected = int(counts.sum()) - drawn - certified - released
    if drawn != rejected + certified:
        raise ValueError(f"rejections: {relation} has {drawn} drawn, but {rejected} rejected and {certified} certified")
    if released > certified:
        raise ValueError(f"rejections: {relation} has {released} released of {certified} certified")
