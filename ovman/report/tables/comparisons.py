"""Tables of tests and failures: arm against arm, the error budget, what navigation costs, and how an agent fails."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.breakdowns import LOST, Verdict
from ovman.analysis.comparisons import Method
from ovman.analysis.navigation import WALKS
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables.columns import (
    INTERVAL,
    MARK,
    RANGE,
    RELATIONS,
    count,
    count_rows,
    counts,
    data_words,
    get,
    joined,
    least,
    mean,
    most,
    numbers,
    of_arm,
    of_relation,
    one_decimal,
    p_values,
    relation_column,
    signed,
    span,
    spread_columns,
    three,
    words,
)
from ovman.report.tables.specs import TableSpec
from ovman.report.tables.success import NAVIGATED
from ovman.report.tables.table import ALL, CSV_AND_MARKDOWN, DATA, PAGE, Column, Group, Value
from ovman.settings import Settings, Source

TABLES: dict[str, TableSpec] = {}

OF_A_PICK = "Poisson-binomial: exact, one-sided, that the pick does as well as the first arm"
"""The test against a stochastic pick, in captions."""
TEST = Column(
    "test", "test", page=lambda test: {Method.MCNEMAR: "McNemar", Method.POISSON_BINOMIAL: f"Poisson-binomial{MARK}"}[test]
)


def _count_of(name: str) -> Value:
    """Write a count, with a decimal if it is an expectation over a stochastic pick."""
    return lambda group: count(group.get(name), group.get("test") == Method.POISSON_BINOMIAL)


def _significance_rows(comparisons: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Keep all relations under the first seed of each pair, and the row over all under each other seed."""
    first_seed = comparisons.groupby("title", sort=False)["seed"].transform("first")
    return comparisons[(comparisons["seed"] == first_seed) | (comparisons["relation"] == ALL)]


def _significance_caption(comparisons: pd.DataFrame, settings: Settings) -> str:
    caption = (
        "Arm against arm on the same episodes: in a win the first alone succeeds, in a loss the second, the baseline. McNemar: "
        "exact, two-sided. p (Holm): corrected for the relations of one comparison."
    )
    stochastic = _significance_rows(comparisons, settings)
    stochastic = stochastic[stochastic["test"] == Method.POISSON_BINOMIAL]
    if len(stochastic):
        caption += f" {MARK} Against a stochastic pick: expectations. {OF_A_PICK}."
    return caption + (" p = 0: the pick cannot reach that." if (stochastic["p"] == 0.0).any() else "")


TABLES["significance"] = TableSpec(
    caption=_significance_caption,
    rows=_significance_rows,
    section=get("title"),
    columns=(
        words("comparison", value=get("title"), formats=CSV_AND_MARKDOWN),
        *data_words("arm", "baseline"),
        numbers("seed"),
        relation_column(),
        *counts("n", "successes"),
        numbers("baseline_successes", "baseline", value=_count_of("baseline_successes")),
        numbers("wins", value=_count_of("wins")),
        numbers("losses", value=_count_of("losses")),
        TEST,
        p_values(),
        p_values("p_holm", "p (Holm)"),
    ),
    wide=True,
)


def _split_significance_caption(comparisons: pd.DataFrame, settings: Settings) -> str:
    stochastic = (comparisons["test"] == Method.POISSON_BINOMIAL).any()
    return (
        "Arm against arm on the same episodes of each split, over all relations, under each seed: a win is an episode on which "
        "the first succeeds and the second, the baseline, does not. Gain: of the success rate. McNemar: exact, two-sided, on "
        "wins and losses; not corrected."
        + (f" {MARK} Against a stochastic pick: expectations. {OF_A_PICK}." if stochastic else "")
    )


def _gain(group: Group) -> float:
    return float((group.get("successes") - group.get("baseline_successes")) / group.get("n"))


TABLES["split_significance"] = TableSpec(
    caption=_split_significance_caption,
    section=lambda group: f"{group.get('split')}, {NAVIGATED[group.get('kind')]}",
    columns=(
        words("split"),
        words("judged", value=lambda group: NAVIGATED[group.get("kind")]),
        words("comparison", value=get("title")),
        *data_words("arm", "baseline"),
        *counts("seed", "n", "successes"),
        numbers("baseline_successes", "baseline", value=_count_of("baseline_successes")),
        numbers("gain", data=signed, value=_gain),
        numbers("wins", value=_count_of("wins")),
        numbers("losses", value=_count_of("losses")),
        TEST,
        p_values(),
    ),
    wide=True,
)


def _worst(value: Value) -> Value:
    """Take a value of the pairing with the least difference, of equal ones with the largest p."""
    return lambda group: value(Group(sorted(group.rows, key=lambda row: (row["difference"], -row["p"])), group.settings))


def _best(value: Value) -> Value:
    """Take a value of the pairing with the greatest difference, of equal ones with the smallest p."""
    return lambda group: value(Group(sorted(group.rows, key=lambda row: (-row["difference"], row["p"])), group.settings))


def _runs(group: Group) -> str:
    return f"{group.get('arm_run')}-{group.get('baseline_run')}"


def _pairings_caption(pairings: pd.DataFrame, settings: Settings) -> str:
    caption = (
        "Each run of an arm against each run of its baseline. Difference: of the success rates, mean over the pairings; worst, "
        "best: the least and the greatest. Wins, losses: of the worst. p: of the pairing to its left, not corrected; McNemar: "
        "exact, two-sided."
    )
    if not (pairings["test"] == Method.POISSON_BINOMIAL).any():
        return caption
    return f"{caption} {MARK} Against a stochastic pick: expectations. {OF_A_PICK}" + (
        "; 0: it cannot." if (pairings["p"] == 0.0).any() else "."
    )


TABLES["pairings"] = TableSpec(
    caption=_pairings_caption,
    by=("title", "relation"),
    section=get("title"),
    columns=(
        words("comparison", value=get("title"), formats=CSV_AND_MARKDOWN),
        *data_words("arm", "baseline"),
        relation_column(),
        numbers("pairings", value=count_rows),
        numbers("difference", data=signed, value=mean("difference")),
        numbers("worst", data=signed, value=_worst(get("difference"))),
        words("worst_runs", "worst runs", _worst(_runs), DATA),
        numbers("worst_wins", "wins", value=_worst(_count_of("wins"))),
        numbers("worst_losses", "losses", value=_worst(_count_of("losses"))),
        p_values("worst_p", value=_worst(get("p"))),
        numbers("best", data=signed, value=_best(get("difference"))),
        words("best_runs", "best runs", _best(_runs), DATA),
        p_values("best_p", value=_best(get("p"))),
        TEST,
        numbers("n"),
    ),
    wide=True,
)


def _budget_caption(steps: pd.DataFrame, settings: Settings) -> str:
    here = [settings.arms[arm] for arm in settings.comparisons.rungs if arm in settings.arms]
    read = dict.fromkeys(str(arm.reading) for arm in here if arm.grounding is Source.HANDED and arm.positions is Source.OWN)
    return (
        "Error budget of the reference agent, static gate: each rung replaces one more part by the truth. Gained, lost: "
        "episodes, against the line above; p: exact two-sided McNemar test. The answer given succeeds by definition. Oracle "
        f"grounding is by the reading {', '.join(read) or 'of no arm'} (table readings). Ranges are Wilson {{confidence}} "
        f"intervals."
    )


TABLES["budget"] = TableSpec(
    caption=_budget_caption,
    rows=lambda steps, settings: steps[steps["relation"] == ALL],
    columns=(
        words("rung"),
        words("arm", formats=DATA),
        numbers("rate", data=three),
        *(numbers(end, data=three, formats=DATA) for end in INTERVAL),
        RANGE,
        numbers("gain", data=signed),
        *counts("gained", "lost"),
        p_values(),
        numbers("n"),
    ),
)


def _static_rate(group: Group) -> float | None:
    successes = group.get("static_successes")
    return None if successes is None else successes / group.get("n")


def _static_page(group: Group) -> str:
    rate = _static_rate(group)
    return "" if rate is None else three(rate) + ("" if joined("lost")(group) else MARK)


TABLES["navigation"] = TableSpec(
    caption=(
        "What executing an answer costs, means over seeds (least and greatest of a seed). Lost: static successes that fail "
        "when executed; gained: static failures that succeed, as the stop test also accepts a stop near the target's box or "
        f"the nearest navigable cell; one count per seed. Static: success of the executed answers ({MARK} of a stochastic pick)."
    ),
    by=("arm",),
    rows=lambda runs, settings: runs[runs["relation"] == ALL],
    columns=(
        words("agent", value=of_arm("system")),
        numbers("static", data=three, value=_static_rate, formats=DATA),
        numbers("static_page", "static", value=_static_page, formats=PAGE),
        *spread_columns("sr", "SR"),
        *spread_columns("spl", "SPL"),
        *spread_columns("spl_given_success", "SPL given success"),
        words("lost", value=joined("lost")),
        words("gained", value=joined("gained")),
        numbers("n"),
        words("seeds", value=joined("seed")),
    ),
    wide=True,
)

TABLES["rescued"] = TableSpec(
    caption=(
        "Predictions that fail on the static gate and succeed when executed (gained), and those of them that stop within "
        "{s.success.radius_m} m of the target's box (rescued): mean, least and most over the seeds, and how far from the "
        "answer the predicted points of the rescued lie."
    ),
    by=("arm", "relation"),
    columns=(
        words("agent", value=of_arm("system")),
        relation_column(),
        numbers("n"),
        numbers("gained", data=one_decimal, value=mean("gained")),
        numbers("rescued", data=one_decimal, value=mean("rescued")),
        numbers("rescued_least", "least", value=least("rescued")),
        numbers("rescued_most", "most", value=most("rescued")),
        numbers("nearest_m", "nearest, m", three, least("nearest_m")),
        numbers("farthest_m", "farthest, m", three, most("farthest_m")),
    ),
)


def _own_interval(group: Group) -> tuple[float, float]:
    successes = mean("own_successes")(group)
    return wilson_interval(successes, int(group.get("n")), group.settings.evaluation.confidence)


TABLES["own_task"] = TableSpec(
    caption=(
        "The same runs under two tests, means over the seeds (least and greatest of a seed). Own task: stopped with any "
        "instance of the category within {s.success.radius_m} m and in sight. This task: Eq. 4. Only own, only this: runs that "
        "succeed under one test alone, per seed. p: exact two-sided McNemar test on these, largest of the seeds. Ranges of the "
        "own task: Wilson {confidence}, as wide as for one pass."
    ),
    by=("arm", "relation"),
    section=of_arm("system"),
    columns=(
        words("agent", value=of_arm("system"), formats=CSV_AND_MARKDOWN),
        relation_column(),
        *spread_columns("own", "own task", "own_rate"),
        numbers("own_low", data=three, value=lambda group: _own_interval(group)[0], formats=DATA),
        numbers("own_high", data=three, value=lambda group: _own_interval(group)[1], formats=DATA),
        words("range", RANGE.title, lambda group: span(*_own_interval(group)), PAGE),
        *spread_columns("rate", "this task"),
        numbers("gap", data=signed, value=mean("gap")),
        words("only_own", "only own", joined("only_own")),
        words("only_here", "only this", joined("only_here")),
        p_values(value=most("p")),
        numbers("n"),
        numbers("seeds", value=count_rows),
    ),
    wide=True,
)

VERDICTS = {
    Verdict.SUCCESS: "success",
    Verdict.ABSTAIN: "abstain",
    Verdict.ELSEWHERE: "elsewhere",
    Verdict.NEAR_MISS: "near miss",
    Verdict.WRONG_INSTANCE: "wrong instance",
}


def _taxonomy_rows(counts: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Return the verdicts on the arm comparisons.agent, the episodes, and what navigation lost under the first seed.

    Raises:
        ValueError: The verdicts on a relation do not add up to its episodes.
    """
    ours = counts[counts["arm"] == settings.comparisons.agent]
    rows = []
    for verdict, title in VERDICTS.items():
        rows.append(ours[ours["verdict"] == verdict].assign(outcome=title, section=""))
    for relation, of in ours[ours["verdict"] != LOST].groupby("relation"):
        if (total := of["episodes"].sum()) != (n := of["n"].iloc[0]):
            raise ValueError(f"the verdicts on {relation} add up to {total} of {n} episodes; make the metrics again")
    rows.append(ours.drop_duplicates("relation").assign(episodes=lambda of: of["n"], outcome="episodes", section=" "))
    lost = ours[ours["verdict"] == LOST]
    rows.append(
        lost[lost["seed"] == lost["seed"].min()].assign(outcome="lost in navigation", section="of success, no sixth outcome")
    )
    return pd.concat(rows, ignore_index=True)


def _taxonomy_caption(counts: pd.DataFrame, settings: Settings) -> str:
    agent, ours = settings.arms[settings.comparisons.agent], counts[counts["arm"] == settings.comparisons.agent]
    near_miss_m, radius_m = settings.evaluation.near_miss_m, settings.success.radius_m
    caption = (
        f"How {agent.system}, {agent.memory}, fails (static gate). Wrong instance: within {radius_m} m of another instance of "
        f"the category in the answer's visit. Near miss: any other up to {near_miss_m} m from the answer; elsewhere: farther."
    )
    if len(ours):
        caption += f" The first five rows partition the {ours.loc[ours['relation'] == ALL, 'n'].iloc[0]} episodes."
    lost = ours[(ours["verdict"] == LOST) & (ours["relation"] == ALL)].sort_values("seed")
    if len(lost):
        first_seed, *others = (f"{row.episodes} under seed {row.seed}" for row in lost.itertuples())
        caption += f" Lost in navigation, a subset of success: fails when executed, under seed {lost['seed'].iloc[0]}"
        caption += f" (in all {', '.join(others)})." if others else "."
    return caption


TABLES["taxonomy"] = TableSpec(
    caption=_taxonomy_caption,
    by=("outcome",),
    rows=_taxonomy_rows,
    section=get("section"),
    columns=(words("outcome"), *(of_relation(relation, "episodes", count) for relation in (*RELATIONS, ALL))),
)


def _mover_caption(rows: pd.DataFrame, settings: Settings) -> str:
    radius_m = rows["radius_m"].iloc[0] if len(rows) else settings.success.radius_m
    return (
        "How far the movers of MOVING episodes go: from where they stood in visit 1 to where visit 2 ended, and from there, "
        f"{WALKS} walks of each with no agent in the way, after so many agent actions. "
        f"R is {radius_m:g} m; also MOVED: episodes whose target satisfies that relation, too."
    )


TABLES["mover"] = TableSpec(
    caption=_mover_caption,
    columns=(
        words("phase"),
        numbers("actions", "agent actions"),
        numbers("n"),
        numbers("least_m", "least (m)", three),
        numbers("median_m", "median (m)", three),
        numbers("greatest_m", "greatest (m)", three),
        numbers("within", "within R", three),
        numbers("moved", "also MOVED"),
    ),
)
