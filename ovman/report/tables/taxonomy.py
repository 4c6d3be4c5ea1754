"""The table of failures of the agent that the settings name."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.taxonomy import LOST, Verdict
from ovman.report.tables.columns import ALL, RELATIONS, count, of_relation, words
from ovman.report.tables.table import SECTION, Table
from ovman.settings import Settings

TITLES = {
    Verdict.SUCCESS: "success",
    Verdict.ABSTAIN: "abstain",
    Verdict.ELSEWHERE: "elsewhere",
    Verdict.NEAR_MISS: "near miss",
    Verdict.WRONG_INSTANCE: "wrong instance",
}


def taxonomy_table(counts: pd.DataFrame, settings: Settings) -> Table:
    """How the arm comparisons.agent fails. counts: rows of `TaxonomyCount`.

    Raises ValueError where the verdicts of a relation do not add up to its episodes.
    """
    ours = counts[counts["arm"] == settings.comparisons.agent]
    verdicts = ours[ours["verdict"] != LOST].pivot_table("episodes", "verdict", "relation", "sum", observed=False)
    episodes = ours.groupby("relation", sort=False)["n"].first()
    for relation, n in episodes.items():
        if (total := verdicts[relation].sum()) != n:
            raise ValueError(f"the verdicts on {relation} add up to {total} of {n} episodes; make the metrics again")
    lost = ours[ours["verdict"] == LOST].pivot(index="seed", columns="relation", values="episodes")
    parts = [pd.DataFrame(columns=["outcome", SECTION])]
    if len(ours):
        parts += [verdicts.loc[list(TITLES)].assign(outcome=list(TITLES.values()), **{SECTION: ""})]
        parts += [episodes.to_frame().T.assign(outcome="episodes", **{SECTION: " "})]
    if len(lost):
        parts += [lost.iloc[:1].assign(outcome="lost in navigation", **{SECTION: "of success, no sixth outcome"})]
    columns = (words("outcome"), *(of_relation(relation, count) for relation in (*RELATIONS, ALL)))
    return Table(_caption(episodes, lost, settings), columns, pd.concat(parts, ignore_index=True))


def _caption(episodes: pd.Series[int], lost: pd.DataFrame, settings: Settings) -> str:
    agent = settings.arms[settings.comparisons.agent]
    near_miss_m, radius_m = settings.evaluation.near_miss_m, settings.success.radius_m
    caption = (
        f"How {agent.system}, {agent.memory}, fails (static gate). Wrong instance: within {radius_m} m of another instance of "
        f"the category in the answer's visit. Near miss: any other up to {near_miss_m} m from the answer; elsewhere: farther."
    )
    if len(episodes):
        caption += f" The first five rows partition the {episodes[ALL]} episodes."
    if len(lost):
        first, *others = lost.index
        totals = ", ".join(f"{lost.loc[seed, ALL]} under seed {seed}" for seed in others)
        caption += (
            " Lost in navigation, a subset of success: fails when executed, under seed "
            f"{first}{f' (in all {totals})' if others else ''}."
        )
    return caption
