"""Tables of success: of arms, by seed, scene and difficulty, on splits, against chance, by coverage and reading of oracles."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from ovman.analysis.breakdowns import INSTANCES, SCENE
from ovman.analysis.rates import Interval
from ovman.report.tables.columns import (
    ARM_COLUMNS,
    EXTREMES,
    INTERVAL,
    MARK,
    RANGE,
    RELATIONS,
    count_rows,
    counts,
    data_words,
    end_columns,
    get,
    interval_text,
    joined,
    least,
    mean,
    most,
    numbers,
    of_arm,
    of_relation,
    one_decimal,
    p_values,
    percent,
    rates_by_relation,
    relation_column,
    signed,
    span,
    three,
    words,
)
from ovman.report.tables.specs import TableSpec
from ovman.report.tables.table import ALL, CONTROLS, CSV_AND_MARKDOWN, DATA, EVERYWHERE, PAGE, Column, Group, Value
from ovman.settings import Arm, Kind, Settings, Source, arms_of, of_kind
from ovman.settings.arms import other_readings

TABLES: dict[str, TableSpec] = {}

NAVIGATED = {Kind.STATIC: "static gate", Kind.EMBODIED: "driving"}
"""The kinds of arms in tables."""


def _in_order(rates: pd.DataFrame, arms: Sequence[Arm]) -> pd.DataFrame:
    """Order rates by their arms. ValueError for an arm that is not among them."""
    place = {arm.name: number for number, arm in enumerate(arms)}
    if strangers := sorted({*rates["arm"]} - {*place}):
        raise ValueError(f"{strangers[0]!r} is not an arm of this table; its arms are {', '.join(place)}")
    return rates.sort_values("arm", key=lambda names: names.map(place), kind="stable")


def _static_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Order agents, ablations, oracles, then controls; the table of readings has the other readings of oracles."""
    arms = arms_of(settings.arms)
    left = other_readings(arms)
    shown = [arm for arm in of_kind(arms, Kind.STATIC) if arm.name not in left]
    shown.sort(key=lambda arm: (arm.control, _count_oracles(arm), arm.ablates is not None))
    return _in_order(rates[~rates["arm"].isin(left)], shown)


def _count_oracles(arm: Arm) -> int:
    return (arm.grounding is Source.HANDED) + 2 * (arm.positions is Source.HANDED)


def _static_section(group: Group) -> str:
    arm = group.settings.arms[group.get("arm")]
    if arm.control:
        return CONTROLS
    if arm.ablates is not None:
        return "a part taken away (ablation)"
    return ("", "oracle grounding (diagnostic)", *["oracle positions (diagnostic)"] * 2)[_count_oracles(arm)]


def _static_caption(rates: pd.DataFrame, settings: Settings) -> str:
    caption = (
        f"Static gate: a prediction succeeds within {settings.success.radius_m} m of the answer. "
        f"Ranges are Wilson {percent(settings.evaluation.confidence)} intervals."
    )
    if (rates["interval"] == Interval.POISSON_BINOMIAL).any():
        caption += f" {MARK} A stochastic pick: its expectation, and the Poisson-binomial range of one pass."
    if (rates["seeds"] > 1).any():
        caption += " Several runs: their means; runs add no episodes."
    return caption


TABLES["static_rates"] = TableSpec(
    caption=_static_caption,
    by=("arm",),
    rows=_static_rows,
    section=_static_section,
    columns=(
        *ARM_COLUMNS,
        *rates_by_relation(ends=(*INTERVAL, *EXTREMES)),
        RANGE,
        numbers("n"),
        numbers("runs", value=get("seeds")),
        words("interval", formats=DATA),
    ),
    wide=True,
    kind=Kind.STATIC,
)

TABLES["embodied_rates"] = TableSpec(
    caption=(
        "Embodied evaluation: success rate (SR) at the stop and SPL, means over the seeds. Ranges are Wilson {confidence} "
        "intervals. Seeds add no episodes and narrow no range. SPL takes the shortest path of the episode, whatever body an "
        "agent has."
    ),
    by=("arm",),
    rows=lambda rates, s: _in_order(rates, sorted(of_kind(arms_of(s.arms), Kind.EMBODIED), key=lambda arm: arm.control)),
    section=lambda group: CONTROLS if of_arm("control")(group) else "",
    columns=(
        words("agent", value=of_arm("system")),
        *rates_by_relation(*RELATIONS, ends=(*INTERVAL, *EXTREMES)),
        numbers("sr", "SR", three, get("rate")),
        *end_columns(ALL, (*INTERVAL, *EXTREMES), key="sr"),
        RANGE,
        numbers("spl", "SPL", three),
        *counts("n", "seeds"),
    ),
    wide=True,
    kind=Kind.EMBODIED,
)


def _of(relation: str, value: Value) -> Value:
    return lambda group: value(group.where(relation=relation))


def _seed_extremes(relation: str) -> tuple[Column, Column]:
    return (
        numbers(f"{relation}_min", data=three, value=_of(relation, least("rate")), formats=DATA),
        numbers(f"{relation}_max", data=three, value=_of(relation, most("rate")), formats=DATA),
    )


def _seed_range(group: Group) -> str:
    return span(least("rate")(group), most("rate")(group))


TABLES["seeds"] = TableSpec(
    caption=(
        "Success under each seed, and for static arms that answer differently each time they run, in each run: the same "
        "episodes every time. Relations: from the least to the greatest of a seed. Spread: the greatest of all minus the "
        "least. All other static arms answer the same under every seed."
    ),
    by=("arm",),
    section=lambda group: {Kind.STATIC: "static gate, by run", Kind.EMBODIED: "embodied, by seed"}[group.get("kind")],
    columns=(
        words("arm", formats=DATA),
        *ARM_COLUMNS[:3],
        *(
            column
            for relation in RELATIONS
            for column in (
                *_seed_extremes(relation),
                of_relation(relation, data=str, value=_of(relation, _seed_range), numeric=False, formats=PAGE),
            )
        ),
        words("each", "each seed", _of(ALL, joined("rate", three))),
        numbers("mean", data=three, value=_of(ALL, mean("rate"))),
        *_seed_extremes(ALL),
        numbers("spread", data=three, value=_of(ALL, lambda group: most("rate")(group) - least("rate")(group))),
        numbers("n"),
    ),
    wide=True,
)


def _within(name: str, **values: str) -> Value:
    return lambda group: group.where(**values).get(name)


KINDS = {Kind.STATIC: "static gate", Kind.EMBODIED: "embodied"}


def _scene(place: str, name: str) -> Value:
    """Take a value of the worst or the best scene, of equal ones the first."""
    choose = min if place == "worst" else max
    return lambda group: choose(group.rows, key=lambda row: row["rate"])[name]


def _scene_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    return (
        words("arm", formats=DATA),
        *ARM_COLUMNS,
        *(
            column
            for place in ("worst", "best")
            for column in (
                words(place, f"{place} scene", _scene(place, "scene")),
                numbers(f"{place}_n", "n", value=_scene(place, "n")),
                numbers(f"{place}_rate", "rate", three, _scene(place, "rate")),
            )
        ),
        numbers("never", "scenes without success", value=lambda group: group.values("rate").count(0.0)),
        numbers("scenes", value=count_rows),
        *(numbers(scene, data=three, value=_within("rate", scene=scene), formats=DATA) for scene in rates["scene"].unique()),
    )


def _scene_caption(rates: pd.DataFrame, settings: Settings) -> str:
    sizes = f"A scene has {rates['n'].min()} to {rates['n'].max()} episodes: " if len(rates) else ""
    return (
        "Success scene by scene, means over seeds or runs: of each arm the scene with the least and the one with the greatest "
        "rate, of equal ones the first, with its number of episodes, and in how many scenes the arm never succeeds. "
        f"{sizes}read the intervals of the metrics. The csv has every scene."
    )


TABLES["scenes"] = TableSpec(
    caption=_scene_caption,
    by=("arm",),
    section=lambda group: KINDS[group.get("kind")],
    columns=_scene_columns,
    wide=True,
)


def _difficulty_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    """Make the columns of every static arm in the csv; pages show the arms of comparisons.difficulty."""
    titles, here = settings.comparisons.difficulty, {*rates["arm"]}
    columns = [words("by", formats=CSV_AND_MARKDOWN), words("group"), numbers("n")]
    for arm in (arm.name for arm in of_kind(arms_of(settings.arms), Kind.STATIC) if arm.name in here):
        columns.append(numbers(arm, titles.get(arm), three, _within("rate", arm=arm), EVERYWHERE if arm in titles else DATA))
        columns += [numbers(f"{arm}_{end}", data=three, value=_within(end, arm=arm), formats=DATA) for end in INTERVAL]
        columns += [words(f"{arm}_range", RANGE.title, _range_of(arm), PAGE)] if arm in titles else []
    return tuple(columns)


def _range_of(arm: str) -> Value:
    return lambda group: interval_text(group.where(arm=arm))


TABLES["difficulty"] = TableSpec(
    caption=(
        "Static success by the number of instances of the queried category and by scene. Ranges are Wilson {confidence} "
        f"intervals ({MARK} of an expectation: the Poisson-binomial range of one realised pass). Scenes have few episodes "
        f"each: read the ranges."
    ),
    by=("by", "group"),
    section=lambda group: {INSTANCES: "by instances of the category", SCENE: "by scene"}[group.get("by")],
    columns=_difficulty_columns,
    wide=True,
)

TABLES["readings"] = TableSpec(
    caption=(
        "Oracle grounding by each reading, static gate: map objects most of whose detections show the category at an IoU of 0.5 "
        "(majority, as in all other tables), with one such detection (any), or nearest to the true positions, within the "
        "success radius (nearest). Gained, lost: episodes, against own grounding; p: exact McNemar test. Ranges are "
        "{confidence} intervals."
    ),
    by=("arm",),
    section=get("map"),
    columns=(
        words("map", formats=DATA),
        words("grounding"),
        words("arm", formats=DATA),
        *rates_by_relation(),
        RANGE,
        numbers("gained", data=one_decimal),
        numbers("lost", data=one_decimal),
        p_values(),
    ),
    wide=True,
)


def _shortcut_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """List the arms of comparisons.shortcuts by relation, then every arm over all."""
    titles = settings.comparisons.shortcuts
    picks = [rates[rates["arm"] == arm].assign(section=f"any instance of the category, {title}") for arm, title in titles.items()]
    return pd.concat([*picks, rates[rates["relation"] == ALL].assign(section="all arms")], ignore_index=True)


def _shortcut_caption(rates: pd.DataFrame, settings: Settings) -> str:
    crowded = rates.loc[rates["relation"] == ALL, "crowded"].max() if len(rates) else 0
    return (
        "The anti-shortcut rule: success and the mean of 1/n, n the instances of the category. The first arms pick an instance "
        "of the category at random, at its true position. Crowded: episodes with another instance within "
        f"{settings.success.radius_m} m of the answer, in the visit that the answer belongs to or in the second; "
        + ("success on them and on the others stands apart." if crowded else "no such episode is left.")
    )


TABLES["shortcuts"] = TableSpec(
    caption=_shortcut_caption,
    rows=_shortcut_rows,
    section=get("section"),
    columns=(
        *data_words("kind", "arm"),
        *ARM_COLUMNS,
        relation_column(),
        numbers("n"),
        numbers("chance", "1/n", three),
        numbers("rate", "success", three),
        numbers("excess", "over 1/n", signed),
        numbers("crowded"),
        numbers("crowded_rate", "crowded: success", three),
        numbers("uncrowded_rate", "others: success", three),
    ),
    wide=True,
)


def _control_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """For each split and kind: agents, then controls, then the chances 1/n and 1/m."""
    blocks = []
    for _, block in rates.groupby(["split", "kind"], sort=False):
        of = [settings.arms[arm] for arm in block["arm"]]
        arms = block.assign(system=[arm.system for arm in of], memory=[arm.memory for arm in of], what="agent")
        arms.loc[block["control"] == 1, "what"] = "control"
        blocks += [arms[arms["what"] == "agent"], arms[arms["what"] == "control"]]
        episodes = block.loc[block["relation"] == ALL, "n"].max()
        chance = (
            block.drop_duplicates("relation")
            .drop(columns=["arm", "low", "high", "spl", "interval"])
            .assign(n=episodes, what="chance")
        )
        blocks += [
            chance.assign(rate=chance["chance"], system="1/n"),
            chance.assign(rate=chance["chance_of_change"], system="1/m"),
        ]
    return pd.concat(blocks, ignore_index=True) if blocks else rates.assign(what="", system="", memory="")


def _navigated(group: Group) -> str:
    return NAVIGATED[group.get("kind")]


TABLES["controls"] = TableSpec(
    caption=(
        "Controls lack something that the task is said to need. Where one comes near to an agent, the split does not measure "
        "what the control lacks. Chance: a random pick among the n instances of the category (mean of 1/n), or among the m "
        f"changes of the kind that defines the episode (mean of 1/m). {MARK} The expectation of a stochastic pick."
    ),
    by=("split", "kind", "what", "arm", "system"),
    rows=_control_rows,
    section=lambda group: f"{group.get('split')}, {_navigated(group)}",
    columns=(
        words("split"),
        words("judged", value=_navigated),
        words("what", ""),
        words("arm", formats=DATA),
        words("system"),
        words("memory"),
        *rates_by_relation(ends=INTERVAL),
        RANGE,
        numbers("spl", "SPL", three),
        numbers("n"),
    ),
    wide=True,
)


def _overview_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Order the entries whose arms are all controls last."""
    is_control = rates.groupby("title")["control"].transform("min")
    return rates.assign(of_controls=is_control).sort_values("of_controls", kind="stable")


def _overview_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    short = {Kind.STATIC: "static", Kind.EMBODIED: "driving"}

    judged = rates[["split", "kind"]].drop_duplicates().itertuples(index=False)
    return (
        words("system", value=get("title")),
        *(
            numbers(f"{split}_{kind}", f"{split}, {short[Kind(kind)]}", three, _within("rate", split=split, kind=kind))
            for split, kind in judged
        ),
    )


def _overview_caption(rates: pd.DataFrame, settings: Settings) -> str:
    episodes = ", ".join(f"{n} of {split}" for split, n in rates.groupby("split", sort=False)["n"].first().items())
    return (
        f"Success over all relations, on the static gate (a point within {settings.success.radius_m} m of the answer) and "
        f"driving (at the stop, mean over the seeds); {episodes}. — means not evaluated. Controls lack something that the task "
        "is said to need. Published systems are reimplemented."
    )


TABLES["overview"] = TableSpec(
    caption=_overview_caption,
    by=("title",),
    rows=_overview_rows,
    section=lambda group: CONTROLS if group.get("of_controls") else "",
    columns=_overview_columns,
)

SHOWN_COVERAGES = (0.25, 0.5, 0.75, 1.0)

TABLES["coverage"] = TableSpec(
    caption=(
        "Success on the static gate where an agent answers only the episodes of which it is surest, by coverage, the share of "
        "the episodes that are answered. Least confidence: of the answers that are given, as the agent itself holds them. "
        "Ranges are Wilson {confidence} intervals."
    ),
    rows=lambda rates, settings: rates[rates["coverage"].isin(SHOWN_COVERAGES)],
    section=lambda group: f"{group.get('split')}, {of_arm('system')(group)}",
    columns=(
        words("split", formats=CSV_AND_MARKDOWN),
        words("system", value=of_arm("system"), formats=CSV_AND_MARKDOWN),
        words("arm", formats=DATA),
        numbers("coverage", data=three),
        numbers("answered"),
        numbers("least_confidence", "least confidence", three),
        numbers("successes"),
        numbers("rate", "success", three),
        RANGE,
    ),
)
