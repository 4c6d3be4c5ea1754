"""Tables of tests and failures: arm against arm, the error budget, what navigation costs, and how an agent fails."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.breakdowns import LOST, Verdict
from ovman.analysis.comparisons import Method
from ovman.analysis.navigation import WALKS
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables import columns as cols
from ovman.report.tables.table import ALL, CSV_AND_MARKDOWN, DATA, PAGE, Column, Group, TableSpec, Value
from ovman.settings import Settings, Source

TABLES: dict[str, TableSpec] = {}

TEST = Column(
    "test", "test", page=lambda test: {Method.MCNEMAR: "McNemar", Method.POISSON_BINOMIAL: f"Poisson-binomial{cols.MARK}"}[test]
)


def _explain_pick(tests: pd.DataFrame, if_zero: str = ".") -> str:
    """Explain the test against a stochastic pick if there is one. if_zero: the end where a p is 0."""
    of_pick = tests[tests["test"] == Method.POISSON_BINOMIAL]
    if of_pick.empty:
        return ""
    return (
        f" {cols.MARK} Against a stochastic pick: expectations. Poisson-binomial: exact, one-sided, that the pick does as well "
        f"as the first arm{if_zero if (of_pick['p'] == 0.0).any() else '.'}"
    )


def _count_of(name: str) -> Value:
    """Write a count, with a decimal if it is an expectation over a stochastic pick."""
    return lambda group: cols.count(group.get(name), group.get("test") == Method.POISSON_BINOMIAL)


def _significance_rows(comparisons: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Keep all relations under the first seed of each pair, and the row over all under each other seed."""
    first_seed = comparisons.groupby("title", sort=False)["seed"].transform("first")
    return comparisons[(comparisons["seed"] == first_seed) | (comparisons["relation"] == ALL)]


def _significance_caption(comparisons: pd.DataFrame, settings: Settings) -> str:
    return (
        "Arm against arm on the same episodes: in a win the first alone succeeds, in a loss the second, the baseline. McNemar: "
        "exact, two-sided. p (Holm): corrected for the relations of one comparison. p (scenes): two-sided, by flipping the "
        "signs of whole scenes."
        + _explain_pick(_significance_rows(comparisons, settings), ". p = 0: the pick cannot reach that.")
    )


TABLES["significance"] = TableSpec(
    caption=_significance_caption,
    rows=_significance_rows,
    section=cols.get("title"),
    columns=(
        cols.words("comparison", value=cols.get("title"), formats=CSV_AND_MARKDOWN),
        *cols.labels("arm", "baseline", formats=DATA),
        cols.numbers("seed"),
        cols.relation_column(),
        *cols.counts("n", "successes"),
        cols.numbers("baseline_successes", "baseline", value=_count_of("baseline_successes")),
        cols.numbers("wins", value=_count_of("wins")),
        cols.numbers("losses", value=_count_of("losses")),
        TEST,
        cols.p_values(),
        cols.p_values("p_holm", "p (Holm)"),
        cols.p_values("p_scenes", "p (scenes)"),
    ),
)


def _split_significance_caption(comparisons: pd.DataFrame, settings: Settings) -> str:
    return (
        "Arm against arm on the same episodes of each split, over all relations, under each seed: a win is an episode on which "
        "the first succeeds and the second, the baseline, does not. Gain: of the success rate. McNemar: exact, two-sided, on "
        "wins and losses; not corrected. p (scenes): by flipping the signs of whole scenes." + _explain_pick(comparisons)
    )


def _gain(group: Group) -> float:
    return float((group.get("successes") - group.get("baseline_successes")) / group.get("n"))


TABLES["split_significance"] = TableSpec(
    caption=_split_significance_caption,
    section=lambda group: f"{group.get('split')}, {cols.judged(group)}",
    columns=(
        cols.words("split"),
        cols.words("judged", value=cols.judged),
        cols.words("comparison", value=cols.get("title")),
        *cols.labels("arm", "baseline", formats=DATA),
        *cols.counts("seed", "n", "successes"),
        cols.numbers("baseline_successes", "baseline", value=_count_of("baseline_successes")),
        cols.numbers("gain", data=cols.signed, value=_gain),
        cols.numbers("wins", value=_count_of("wins")),
        cols.numbers("losses", value=_count_of("losses")),
        TEST,
        cols.p_values(),
        cols.p_values("p_scenes", "p (scenes)"),
    ),
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
    return (
        "Each run of an arm against each run of its baseline. Difference: of the success rates, mean over the pairings; worst, "
        "best: the least and the greatest. Wins, losses: of the worst. p: of the pairing to its left, not corrected; McNemar: "
        "exact, two-sided." + _explain_pick(pairings, "; 0: it cannot.")
    )


TABLES["pairings"] = TableSpec(
    caption=_pairings_caption,
    by=("title", "relation"),
    section=cols.get("title"),
    columns=(
        cols.words("comparison", value=cols.get("title"), formats=CSV_AND_MARKDOWN),
        *cols.labels("arm", "baseline", formats=DATA),
        cols.relation_column(),
        cols.numbers("pairings", value=cols.count_rows),
        cols.numbers("difference", data=cols.signed, value=cols.mean("difference")),
        cols.numbers("worst", data=cols.signed, value=_worst(cols.get("difference"))),
        cols.words("worst_runs", "worst runs", _worst(_runs), DATA),
        cols.numbers("worst_wins", "wins", value=_worst(_count_of("wins"))),
        cols.numbers("worst_losses", "losses", value=_worst(_count_of("losses"))),
        cols.p_values("worst_p", value=_worst(cols.get("p"))),
        cols.numbers("best", data=cols.signed, value=_best(cols.get("difference"))),
        cols.words("best_runs", "best runs", _best(_runs), DATA),
        cols.p_values("best_p", value=_best(cols.get("p"))),
        TEST,
        cols.numbers("n"),
    ),
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
        cols.words("rung"),
        cols.words("arm", formats=DATA),
        *cols.rates("rate"),
        *(cols.numbers(end, data=cols.three, formats=DATA) for end in cols.INTERVAL),
        cols.RANGE,
        cols.numbers("gain", data=cols.signed),
        *cols.counts("gained", "lost"),
        cols.p_values(),
        cols.numbers("n"),
    ),
    wide=False,
)


def _static_rate(group: Group) -> float | None:
    successes = group.get("static_successes")
    return None if successes is None else successes / group.get("n")


def _static_page(group: Group) -> str:
    rate = _static_rate(group)
    return "" if rate is None else cols.three(rate) + ("" if cols.joined("lost")(group) else cols.MARK)


TABLES["navigation"] = TableSpec(
    caption=(
        "What executing an answer costs, means over seeds (least and greatest of a seed). Lost: static successes that fail "
        "when executed; gained: static failures that succeed, as the stop test also accepts a stop near the target's box or "
        "the nearest navigable cell; one count per seed. Static: success of the executed answers "
        f"({cols.MARK} of a stochastic pick)."
    ),
    by=("arm",),
    rows=lambda runs, settings: runs[runs["relation"] == ALL],
    columns=(
        cols.words("agent", value=cols.of_arm("system")),
        cols.numbers("static", data=cols.three, value=_static_rate, formats=DATA),
        cols.numbers("static_page", "static", value=_static_page, formats=PAGE),
        *cols.spread_columns("sr", "SR"),
        *cols.spread_columns("spl", "SPL"),
        *cols.spread_columns("spl_given_success", "SPL given success"),
        cols.words("lost", value=cols.joined("lost")),
        cols.words("gained", value=cols.joined("gained")),
        cols.numbers("n"),
        cols.words("seeds", value=cols.joined("seed")),
    ),
)

TABLES["rescued"] = TableSpec(
    caption=(
        "Predictions that fail on the static gate and succeed when executed (gained), and those of them that stop within "
        "{s.success.radius_m} m of the target's box (rescued): mean, least and most over the seeds, and how far from the "
        "answer the predicted points of the rescued lie."
    ),
    by=("arm", "relation"),
    columns=(
        cols.words("agent", value=cols.of_arm("system")),
        cols.relation_column(),
        cols.numbers("n"),
        cols.numbers("gained", data=cols.one_decimal, value=cols.mean("gained")),
        cols.numbers("rescued", data=cols.one_decimal, value=cols.mean("rescued")),
        cols.numbers("rescued_least", "least", value=cols.least("rescued")),
        cols.numbers("rescued_most", "most", value=cols.most("rescued")),
        cols.numbers("nearest_m", "nearest, m", cols.three, cols.least("nearest_m")),
        cols.numbers("farthest_m", "farthest, m", cols.three, cols.most("farthest_m")),
    ),
    wide=False,
)


def _own_interval(group: Group) -> tuple[float, float]:
    successes = cols.mean("own_successes")(group)
    return wilson_interval(successes, int(group.get("n")), group.settings.evaluation.confidence)


TABLES["own_task"] = TableSpec(
    caption=(
        "The same runs under two tests, means over the seeds (least and greatest of a seed). Own task: stopped with any "
        "instance of the category within {s.success.radius_m} m and in sight. This task: Eq. 4. Only own, only this: runs that "
        "succeed under one test alone, per seed. p: exact two-sided McNemar test on these, largest of the seeds. Ranges of the "
        "own task: Wilson {confidence}, as wide as for one pass."
    ),
    by=("arm", "relation"),
    section=cols.of_arm("system"),
    columns=(
        cols.words("agent", value=cols.of_arm("system"), formats=CSV_AND_MARKDOWN),
        cols.relation_column(),
        *cols.spread_columns("own", "own task", "own_rate"),
        cols.numbers("own_low", data=cols.three, value=lambda group: _own_interval(group)[0], formats=DATA),
        cols.numbers("own_high", data=cols.three, value=lambda group: _own_interval(group)[1], formats=DATA),
        cols.words("range", cols.RANGE.title, lambda group: cols.span(*_own_interval(group)), PAGE),
        *cols.spread_columns("rate", "this task"),
        cols.numbers("gap", data=cols.signed, value=cols.mean("gap")),
        cols.words("only_own", "only own", cols.joined("only_own")),
        cols.words("only_here", "only this", cols.joined("only_here")),
        cols.p_values(value=cols.most("p")),
        cols.numbers("n"),
        cols.numbers("seeds", value=cols.count_rows),
    ),
)


def _taxonomy_rows(counts: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Return the verdicts on the arm comparisons.agent, the episodes, and what navigation lost under the first seed.

    Raises:
        ValueError: The verdicts on a relation do not add up to its episodes.
    """
    ours = counts[counts["arm"] == settings.comparisons.agent]
    rows = [ours[ours["verdict"] == verdict].assign(outcome=verdict.replace("_", " "), section="") for verdict in Verdict]
    for relation, of in ours[ours["verdict"] != LOST].groupby("relation"):
        if (total := of["episodes"].sum()) != (n := of["n"].iloc[0]):
            raise ValueError(f"the verdicts on {relation} add up to {total} of {n} episodes; make the metrics again")
    whole = ours.drop_duplicates("relation")
    whole = whole.assign(episodes=whole["n"], outcome="episodes", section=" ")
    lost = ours[ours["verdict"] == LOST].assign(outcome="lost in navigation", section="of success, no sixth outcome")
    parts: list[pd.DataFrame] = [*rows, whole, lost[lost["seed"] == lost["seed"].min()]]
    return pd.concat(parts, ignore_index=True)


def _taxonomy_caption(counts: pd.DataFrame, settings: Settings) -> str:
    agent, ours = settings.arms[settings.comparisons.agent], counts[counts["arm"] == settings.comparisons.agent]
    near_miss_m, radius_m = settings.evaluation.near_miss_m, settings.success.radius_m
    caption = (
        f"How {agent.system}, {agent.memory}, fails (static gate). Wrong instance: within {radius_m} m of another instance of "
        f"the category in the answer's visit. Near miss: any other up to {near_miss_m} m from the answer; elsewhere: farther. "
        f"The first five rows partition the {ours.loc[ours['relation'] == ALL, 'n'].max()} episodes."
    )
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
    section=cols.get("section"),
    columns=(cols.words("outcome"), *(cols.of_relation(relation, "episodes", cols.count) for relation in (*cols.RELATIONS, ALL))),
    wide=False,
)


def _mover_caption(rows: pd.DataFrame, settings: Settings) -> str:
    return (
        "How far the movers of MOVING episodes go: from where they stood in visit 1 to where visit 2 ended, and from there, "
        f"{WALKS} walks of each with no agent in the way, after so many agent actions. "
        f"R is {settings.success.radius_m:g} m; also MOVED: episodes whose target satisfies that relation, too."
    )


TABLES["mover"] = TableSpec(
    caption=_mover_caption,
    columns=(
        cols.words("phase"),
        *cols.counts(actions="agent actions", n="n"),
        *cols.rates(least_m="least (m)", median_m="median (m)", greatest_m="greatest (m)", within="within R"),
        cols.numbers("moved", "also MOVED"),
    ),
    wide=False,
)
