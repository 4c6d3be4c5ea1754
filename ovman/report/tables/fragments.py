"""The table of the objects that targets fall into in the agent's maps, and of the targets that are not grounded."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import numbers, relation_column
from ovman.report.tables.table import Table
from ovman.settings import Settings


def fragments_table(relations: pd.DataFrame, settings: Settings) -> Table:
    """A row a relation. relations: rows of `Fragments`."""
    columns = (
        relation_column(),
        numbers("n"),
        numbers("seen", "detected"),
        numbers("objects", "objects a target", "{:.2f}".format),
        numbers("several", "several"),
        numbers("grounded"),
        numbers("grounded_success", "grounded, success"),
        numbers("grounded_wrong", "grounded, wrong"),
        numbers("grounded_abstained", "grounded, abstained"),
        numbers("missing"),
        numbers("missing_success", "missing, success"),
        numbers("missing_wrong", "missing, wrong"),
        numbers("missing_abstained", "missing, abstained"),
    )
    arm = settings.arms[settings.comparisons.memory.arm]
    caption = (
        f"The targets in the maps of {arm.system}, {arm.memory}. Detected: in the answer's visit; objects a target: that its "
        "detections fall into; several: targets with more than one. Grounded: an object of the target is in the grounded set of "
        "every visit that it is in; missing: the others; each with the outcome on the static gate."
    )
    return Table(caption, columns, relations.drop(columns="arm"), wide=True)
