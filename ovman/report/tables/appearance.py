"""The table of what cues of appearance are worth in the association."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.appearance import APART
from ovman.report.tables.columns import (
    ALL,
    RELATIONS,
    interval_columns,
    numbers,
    of_relation,
    p_values,
    percent,
    range_column,
    span,
    three,
    words,
)
from ovman.report.tables.table import CSV_AND_MARKDOWN, SECTION, Table
from ovman.settings import Settings

TITLES = {ALL: "weights fitted on all pairs of the category", APART: "weights fitted on pairs that are apart"}
NAMES = {"clip": "CLIP", "histogram": "histogram", "extent": "extent"}


def appearance_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """One row a variant, the split of its fit and the split of its test, by which pairs count. rates: rows of `Appearance`."""
    confidence, tau_m = settings.evaluation.confidence, settings.admissibility.tau_m
    keys = ["pairs", "cues", "fitted_on", "split"]
    rows = [_row(of_variant) for _, of_variant in rates.groupby(keys, sort=False)]
    columns = (
        words("pairs", formats=CSV_AND_MARKDOWN),
        words("cues"),
        words("fitted", "fitted on"),
        words("split", "tested on"),
        words("weights"),
        numbers("same"),
        numbers("different"),
        numbers("auroc", "AUROC", three),
        *(of_relation(relation, three) for relation in (*RELATIONS, ALL)),
        *interval_columns("all"),
        range_column(confidence),
        numbers("wins"),
        numbers("losses"),
        p_values("p", "p"),
        numbers("n"),
    )
    caption = (
        "Cues in the association cost of the reference agent with oracle grounding: features (CLIP), hue-saturation histograms, "
        "back-projected extents. Weights: shares, in this order, of best AUROC (same against different instances) on the split "
        f"fitted on. Apart: pairs at least {tau_m} m apart. Success: static gate, Wilson {percent(confidence)} intervals; wins, "
        "losses, exact McNemar p: against CLIP alone."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _row(rates: pd.DataFrame) -> dict[str, object]:
    whole = rates[rates["relation"] == ALL].iloc[0]
    cues = str(whole["cues"]).split(" + ")
    row: dict[str, object] = {
        SECTION: TITLES[whole["pairs"]],
        "pairs": whole["pairs"],
        "cues": " + ".join(NAMES[cue] for cue in cues),
        "fitted": whole["fitted_on"] or "",
        "split": whole["split"],
        "weights": " + ".join(f"{whole[cue]:.2f}" for cue in cues),
        "same": whole["same"],
        "different": whole["different"],
    }
    if pd.notna(whole["auroc"]):
        row["auroc"] = whole["auroc"]
    if pd.isna(whole["n"]):
        return row
    row |= {str(rate.relation): rate.rate for rate in rates.itertuples()}
    row |= {"all_low": whole["low"], "all_high": whole["high"], "range": span(whole["low"], whole["high"])}
    return row | {key: whole[key] for key in ("wins", "losses", "p", "n")}
