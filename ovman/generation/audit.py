"""The audit of Algorithm 1: what was drawn, rejected for which reason, certified and released, by relation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from ovman.records.task import Rejection, Relation

COLUMNS = ("relation", "stage", "reason", "count")
DRAWN, CERTIFIED, RELEASED = "drawn", "certified", "released"
"""Stages of the audit in addition to those of rejections."""


def audit(
    rejections: Mapping[str, Rejection | None], relation_of: Mapping[str, Relation], released: Iterable[str]
) -> list[tuple[str, str, str, int]]:
    """Count candidates per relation, stage and reason: drawn, rejected, certified and released. Rows of COLUMNS.

    rejections, relation_of: by the id of a trial; released: ids of the trials that became episodes.
    """
    released = set(released)
    rows = []
    for relation in Relation:
        ids = [k for k in rejections if relation_of[k] is relation]
        counts = Counter(r for k in ids if (r := rejections[k]) is not None)
        rows.append((relation.value, DRAWN, "", len(ids)))
        rows += [(relation.value, r.stage.value, r.value, counts[r]) for r in Rejection if counts[r]]
        rows.append((relation.value, CERTIFIED, "", len(ids) - counts.total()))
        rows.append((relation.value, RELEASED, "", sum(k in released for k in ids)))
    return rows
