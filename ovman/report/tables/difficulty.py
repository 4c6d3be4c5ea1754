"""The table of static success by number of instances of the category and by scene."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.difficulty import By
from ovman.analysis.rates import Interval
from ovman.report.tables.columns import MARK, interval_columns, numbers, percent, range_column, span, three, words
from ovman.report.tables.table import CSV_AND_MARKDOWN, DATA, SECTION, Column, Table
from ovman.settings import Kind, Settings, arms_of, of_kind

SECTIONS = {By.INSTANCES: "by instances of the category", By.SCENE: "by scene"}


def difficulty_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """Groups of episodes by arms. rates: rows of `Difficulty`. Pages show the arms of comparisons.difficulty, the csv all."""
    confidence, titles = settings.evaluation.confidence, settings.comparisons.difficulty
    here = {*rates["arm"]}
    arms = [arm.name for arm in of_kind(arms_of(settings.arms), Kind.STATIC) if arm.name in here]
    groups = pd.MultiIndex.from_frame(rates[["by", "group"]].drop_duplicates())
    made = [rates.drop_duplicates(["by", "group"]).set_index(["by", "group"])[["n"]]]
    for arm in arms:
        of_arm = rates[rates["arm"] == arm].set_index(["by", "group"])
        figures = of_arm[["rate", "low", "high"]].set_axis([arm, f"{arm}_low", f"{arm}_high"], axis=1)
        if arm in titles:
            marks = of_arm["interval"].map(lambda interval: MARK if interval == Interval.POISSON_BINOMIAL else "")
            ranges = [span(*ends) for ends in zip(of_arm["low"], of_arm["high"], marks, strict=True)]
            figures[f"{arm}_range"] = pd.Series(ranges, index=of_arm.index, dtype=object)
        made.append(figures.reindex(groups))
    rows = pd.concat(made, axis=1).reset_index()
    rows[SECTION] = [SECTIONS[By(by)] for by in rows["by"]]
    columns = (
        words("by", formats=CSV_AND_MARKDOWN),
        words("group"),
        numbers("n"),
        *(column for arm in arms for column in _columns(arm, titles.get(arm), confidence)),
    )
    caption = (
        "Static success by the number of instances of the queried category and by scene. Ranges are Wilson "
        f"{percent(confidence)} intervals ({MARK} of an expectation: the Poisson-binomial range of one realised pass). "
        "Scenes have few episodes each: read the ranges."
    )
    return Table(caption, columns, rows, wide=True)


def _columns(arm: str, title: str | None, confidence: float) -> tuple[Column, ...]:
    if title is None:
        return numbers(arm, arm, three, DATA), *interval_columns(arm)
    return numbers(arm, title, three), *interval_columns(arm), range_column(confidence, f"{arm}_range")
