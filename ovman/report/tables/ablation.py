"""The table of what each setting of a split costs each arm."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import (
    ALL,
    ARM_COLUMNS,
    RELATIONS,
    arms_frame,
    numbers,
    of_relation,
    range_column,
    signed,
    span,
    three,
    words,
)
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Settings

TITLES = {
    "none": "none",
    "others": "other changes",
    "second_tour": "another tour",
    "light": "another light",
    "sensors": "sensors that err",
    "all": "all",
}
"""What the settings in force are called, by the names of `ovman.records.episode.VARIANTS`."""


def ablation_table(split: str, rates: pd.DataFrame, settings: Settings) -> Table:
    """Every arm on every variant of a split's episodes. rates: rows of `AblationRate`.

    ValueError for a variant without a title and for an arm without rates on the variant without settings.
    """
    confidence = settings.evaluation.confidence
    rows = []
    for arm in dict.fromkeys(rates["arm"]):
        of_arm = rates[rates["arm"] == arm]
        plain = of_arm[(of_arm["variant"] == "none") & (of_arm["relation"] == ALL)]["rate"]
        if plain.empty:
            raise ValueError(f"{arm} has no rates without the settings of {split}; make the ablation again")
        for variant in dict.fromkeys(of_arm["variant"]):
            if variant not in TITLES:
                raise ValueError(f"{variant!r} is no variant; the variants are {', '.join(TITLES)}")
            here = of_arm[of_arm["variant"] == variant].set_index("relation")
            whole = here.loc[ALL]
            rows.append(
                {
                    "arm": arm,
                    "variant": variant,
                    "in_force": TITLES[variant],
                    **{relation: here["rate"].get(relation) for relation in (*RELATIONS, ALL)},
                    "cost": whole["rate"] - plain.iloc[0],
                    "low": whole["low"],
                    "high": whole["high"],
                    "range": span(whole["low"], whole["high"]),
                    "n": whole["n"],
                    SECTION: "",
                }
            )
    frame = pd.DataFrame(rows).join(arms_frame(settings), on="arm")
    columns = (
        words("arm", formats=DATA),
        words("variant", formats=DATA),
        *ARM_COLUMNS,
        words("in_force", "in force"),
        *(of_relation(relation, three) for relation in (*RELATIONS, ALL)),
        numbers("cost", "cost", signed),
        range_column(confidence),
        numbers("low", "low", three, DATA),
        numbers("high", "high", three, DATA),
        numbers("n"),
    )
    caption = (
        f"What each setting of the split {split} costs, static gate: its episodes with none of the settings in force, with each "
        "alone, and with all. Query, answer and spawn are the same in every row, and nothing is certified anew: a "
        "waypoint on which a thing now stands gives way to the nearest free position. Cost is the difference from the row with "
        "none."
    )
    return Table(caption, columns, frame, wide=True)
