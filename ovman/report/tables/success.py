"""Tables of success: of arms, by seed, scene and difficulty, on splits, against chance, by coverage and reading of oracles."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from ovman.analysis.bounds import INVERSES, MARGIN
from ovman.analysis.breakdowns import INSTANCES, SCENE
from ovman.analysis.rates import Interval
from ovman.language.phrases import SOURCES
from ovman.report.tables import columns as cols
from ovman.report.tables.table import ALL, CONTROLS, CSV_AND_MARKDOWN, DATA, EVERYWHERE, PAGE, Column, Group, TableSpec, Value
from ovman.settings import Arm, Kind, Settings, Source, arms_of, of_kind
from ovman.settings.arms import Track, other_readings

TABLES: dict[str, TableSpec] = {}


def _in_order(rates: pd.DataFrame, arms: Sequence[Arm]) -> pd.DataFrame:
    place = {arm.name: number for number, arm in enumerate(arms)}
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
        f"Ranges are Wilson {{confidence}} intervals."
    )
    if (rates["interval"] == Interval.POISSON_BINOMIAL).any():
        caption += f" {cols.MARK} A stochastic pick: its expectation, and the Poisson-binomial range of one pass."
    if (rates["seeds"] > 1).any():
        caption += " Several runs: their means; runs add no episodes."
    return caption + cols.SCENE_CAPTION


TABLES["static_rates"] = TableSpec(
    caption=_static_caption,
    by=("arm",),
    rows=_static_rows,
    section=_static_section,
    columns=(
        *cols.ARM_COLUMNS,
        *cols.rates_by_relation(ends=(*cols.INTERVAL, *cols.EXTREMES)),
        cols.RANGE,
        *cols.BY_SCENE,
        cols.numbers("n"),
        cols.numbers("runs", value=cols.get("seeds")),
        cols.words("interval", formats=DATA),
    ),
    kind=Kind.STATIC,
)

TABLES["embodied_rates"] = TableSpec(
    caption=(
        "Embodied evaluation: success rate (SR) at the stop and SPL, means over the seeds. Ranges are Wilson {confidence} "
        "intervals. Seeds add no episodes and narrow no range. SPL takes the shortest path of the episode, whatever body an "
        f"agent has.{cols.SCENE_CAPTION}"
    ),
    by=("arm",),
    rows=lambda rates, s: _in_order(rates, sorted(of_kind(arms_of(s.arms), Kind.EMBODIED), key=lambda arm: arm.control)),
    section=lambda group: CONTROLS if cols.of_arm("control")(group) else "",
    columns=(
        cols.words("agent", value=cols.of_arm("system")),
        *cols.rates_by_relation(*cols.RELATIONS, ends=(*cols.INTERVAL, *cols.EXTREMES)),
        cols.numbers("sr", "SR", cols.three, cols.get("rate")),
        *cols.end_columns(ALL, (*cols.INTERVAL, *cols.EXTREMES), key="sr"),
        cols.RANGE,
        *cols.BY_SCENE,
        cols.numbers("spl", "SPL", cols.three),
        *cols.counts("n", "seeds"),
    ),
    kind=Kind.EMBODIED,
)


def _seed_extremes(relation: str) -> tuple[Column, Column]:
    return (
        cols.numbers(f"{relation}_min", data=cols.three, value=cols.least("rate", relation=relation), formats=DATA),
        cols.numbers(f"{relation}_max", data=cols.three, value=cols.most("rate", relation=relation), formats=DATA),
    )


def _seed_range(relation: str) -> Value:
    return lambda group: cols.span(cols.least("rate", relation=relation)(group), cols.most("rate", relation=relation)(group))


def _seed_spread(group: Group) -> float:
    return float(cols.most("rate", relation=ALL)(group) - cols.least("rate", relation=ALL)(group))


TABLES["seeds"] = TableSpec(
    caption=(
        "Success under each seed, and for static arms that answer differently each time they run, in each run: the same "
        "episodes every time. Relations: from the least to the greatest of a seed. Spread: the greatest of all minus the "
        "least. All other static arms answer the same under every seed."
    ),
    by=("arm",),
    section=lambda group: {Kind.STATIC: "static gate, by run", Kind.EMBODIED: "embodied, by seed"}[group.get("kind")],
    columns=(
        cols.words("arm", formats=DATA),
        *cols.ARM_COLUMNS[:3],
        *(
            column
            for relation in cols.RELATIONS
            for column in (
                *_seed_extremes(relation),
                cols.of_relation(relation, data=str, value=_seed_range(relation), numeric=False, formats=PAGE),
            )
        ),
        cols.words("each", "each seed", cols.joined("rate", cols.three, relation=ALL)),
        cols.numbers("mean", data=cols.three, value=cols.mean("rate", relation=ALL)),
        *_seed_extremes(ALL),
        cols.numbers("spread", data=cols.three, value=_seed_spread),
        cols.numbers("n"),
    ),
)


def _scene(place: str, name: str) -> Value:
    """Take a value of the worst or the best scene, of equal ones the first."""
    choose = min if place == "worst" else max
    return lambda group: choose(group.rows, key=lambda row: row["rate"])[name]


def _scene_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    return (
        cols.words("arm", formats=DATA),
        *cols.ARM_COLUMNS,
        *(
            column
            for place in ("worst", "best")
            for column in (
                cols.words(place, f"{place} scene", _scene(place, "scene")),
                cols.numbers(f"{place}_n", "n", value=_scene(place, "n")),
                cols.numbers(f"{place}_rate", "rate", cols.three, _scene(place, "rate")),
            )
        ),
        cols.numbers("never", "scenes without success", value=lambda group: group.values("rate").count(0.0)),
        cols.numbers("scenes", value=cols.count_rows),
        *(
            cols.numbers(scene, data=cols.three, value=cols.get("rate", scene=scene), formats=DATA)
            for scene in rates["scene"].unique()
        ),
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
    section=lambda group: {Kind.STATIC: "static gate", Kind.EMBODIED: "embodied"}[group.get("kind")],
    columns=_scene_columns,
)


def _difficulty_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    """Make the columns of every static arm in the csv; pages show the arms of comparisons.difficulty."""
    titles, here = settings.comparisons.difficulty, {*rates["arm"]}
    columns = [cols.words("by", formats=CSV_AND_MARKDOWN), cols.words("group"), cols.numbers("n")]
    for arm in (arm.name for arm in of_kind(arms_of(settings.arms), Kind.STATIC) if arm.name in here):
        columns.append(
            cols.numbers(arm, titles.get(arm), cols.three, cols.get("rate", arm=arm), EVERYWHERE if arm in titles else DATA)
        )
        columns += [
            cols.numbers(f"{arm}_{end}", data=cols.three, value=cols.get(end, arm=arm), formats=DATA) for end in cols.INTERVAL
        ]
        columns += [cols.words(f"{arm}_range", cols.RANGE.title, cols.interval(arm=arm), PAGE)] if arm in titles else []
    return tuple(columns)


TABLES["difficulty"] = TableSpec(
    caption=(
        "Static success by the number of instances of the queried category and by scene. Ranges are Wilson {confidence} "
        f"intervals ({cols.MARK} of an expectation: the Poisson-binomial range of one realised pass). Scenes have few episodes "
        f"each: read the ranges."
    ),
    by=("by", "group"),
    section=lambda group: {INSTANCES: "by instances of the category", SCENE: "by scene"}[group.get("by")],
    columns=_difficulty_columns,
)

TABLES["readings"] = TableSpec(
    caption=(
        "Oracle grounding by each reading, static gate: map objects most of whose detections show the category at an IoU of 0.5 "
        "(majority, as in all other tables), with one such detection (any), nearest to the true positions, within the success "
        "radius (nearest), or within it of a recorded place in either visit (places). Gained, lost: episodes, against own "
        "grounding; p: exact McNemar test. Ranges are {confidence} intervals."
    ),
    by=("arm",),
    section=cols.get("map"),
    columns=(
        cols.words("map", formats=CSV_AND_MARKDOWN),
        cols.words("grounding"),
        cols.words("arm", formats=DATA),
        *cols.rates_by_relation(),
        cols.RANGE,
        *cols.counts("gained", "lost", data=cols.one_decimal),
        cols.p_values(),
    ),
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
    section=cols.get("section"),
    columns=(
        *cols.labels("kind", "arm", formats=DATA),
        *cols.ARM_COLUMNS,
        cols.relation_column(),
        cols.numbers("n"),
        *cols.rates(chance="1/n", rate="success"),
        cols.numbers("excess", "over 1/n", cols.signed),
        cols.numbers("crowded"),
        *cols.rates(crowded_rate="crowded: success", uncrowded_rate="others: success"),
    ),
)


def _control_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """For each split and kind: agents, then controls, then the chances 1/n and 1/m."""
    blocks = []
    for _, block in rates.groupby(["split", "kind"], sort=False):
        of = [settings.arms[arm] for arm in block["arm"]]
        arms = block.assign(system=[arm.system for arm in of], memory=[arm.memory for arm in of], what="agent")
        arms.loc[block["control"] == 1, "what"] = "control"
        blocks += [arms[arms["what"] == "agent"], arms[arms["what"] == "control"]]
        chance = block.drop_duplicates("relation").drop(columns=["arm", "low", "high", "spl", "interval"])
        chance = chance.assign(n=block.loc[block["relation"] == ALL, "n"].max(), what="chance")
        titles = {"chance": "1/n", "chance_of_change": "1/m"}
        blocks += [chance.assign(rate=chance[column], system=title) for column, title in titles.items()]
    return pd.concat(blocks, ignore_index=True) if blocks else rates.assign(what="", system="", memory="")


TABLES["controls"] = TableSpec(
    caption=(
        "Controls lack something that the task is said to need. Where one comes near to an agent, the split does not measure "
        "what the control lacks. Chance: a random pick among the n instances of the category (mean of 1/n), or among the m "
        f"changes of the kind that defines the episode (mean of 1/m). {cols.MARK} The expectation of a stochastic pick."
    ),
    by=("split", "kind", "what", "arm", "system"),
    rows=_control_rows,
    section=lambda group: f"{group.get('split')}, {cols.judged(group)}",
    columns=(
        cols.words("split"),
        cols.words("judged", value=cols.judged),
        cols.words("what", ""),
        cols.words("arm", formats=DATA),
        *cols.labels("system", "memory"),
        *cols.rates_by_relation(ends=cols.INTERVAL),
        cols.RANGE,
        cols.numbers("spl", "SPL", cols.three),
        cols.numbers("n"),
    ),
)


def _bound_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """For each kind and each thing that arms are blind to: the bound of each relation, then the arms."""
    shown = rates[rates["by"] == "relation"].rename(columns={"group": "relation"})
    of = [settings.arms[arm] for arm in shown["arm"]]
    shown = shown.assign(system=[arm.system for arm in of], memory=[arm.memory for arm in of])
    blocks = []
    for kind in shown["kind"].unique():
        for blind, title in BOUND_TITLES.items():
            block = shown[(shown["kind"] == kind) & (shown["blind"] == blind)]
            bound = block.drop_duplicates("relation")
            empty = dict.fromkeys(("arm", "memory"), "") | dict.fromkeys(("excess", "low", "high"))
            blocks += [bound.assign(rate=bound["bound"], system=title, **empty), block]
    return pd.concat([block.astype(object) for block in blocks], ignore_index=True) if blocks else shown


def _beyond(group: Group) -> str | None:
    """Name the relations in which an arm exceeds its bound."""
    if not group.get("arm") or not group.values("bound"):
        return None
    beyond = [row["relation"].upper() for row in group.rows if not row["within"]]
    return ", ".join(beyond) if beyond else "none"


def _bounds_caption(rates: pd.DataFrame, settings: Settings) -> str:
    whole = rates[rates["group"] == ALL]
    means = {name: float(whole[name].iloc[0]) for name in INVERSES if len(whole) and not whole[name].isna().all()}
    return (
        "Agents that are blind to a part of the query, next to their chance: 1/m for the noun, m the queries of the same world "
        "pair with the same relation (without pairs: the changes alike); 1/k for the relation, k those with the same noun; 1/n "
        f"for a visit, n the instances of the category. Beyond: the rate exceeds the chance by more than {MARGIN}. Mean of "
        + ", ".join(f"1/{name[-1]} {cols.three(mean)}" for name, mean in means.items())
        + ". The csv of the metrics has every noun."
    )


BOUND_TITLES = {"noun": "1/m", "relation": "1/k", "visit": "1/n"}

TABLES["bounds"] = TableSpec(
    caption=_bounds_caption,
    by=("kind", "blind", "system", "memory", "arm"),
    rows=_bound_rows,
    section=lambda group: f"blind to the {group.get('blind')}, {cols.judged(group)}",
    columns=(
        cols.words("judged", value=cols.judged),
        cols.words("blind", "blind to"),
        cols.words("arm", formats=DATA),
        *cols.labels("system", "memory"),
        *cols.rates_by_relation(ends=cols.INTERVAL),
        cols.numbers("excess", "over the chance", cols.signed),
        cols.words("beyond", value=_beyond),
        cols.numbers("n"),
    ),
)


def _columns_of_source(source: str) -> tuple[Column, ...]:
    """Return the columns of the episodes whose phrase is from a source: their number, and the success in each track."""
    rates = {track: cols.get("rate", track=track, source=source) for track in Track}
    return (
        cols.numbers(f"n_{source}", f"n, {source}", value=cols.get("n", track=Track.WORDS, source=source)),
        *(cols.numbers(f"{track}_{source}", f"{track}, {source}", cols.three, rate) for track, rate in rates.items()),
    )


TABLES["words"] = TableSpec(
    caption=(
        "Success with category and relation (paper), and with a sentence and its noun phrase alone (words), over all relations. "
        "All arms are asked about an episode in the same words. The phrase is from WordNet, from people who described objects, "
        "or the category's noun where neither has one. The range is the {confidence} interval in the words track."
    ),
    by=("arm",),
    columns=(
        *cols.ARM_COLUMNS[:2],
        *(column for source in (ALL, *SOURCES) for column in _columns_of_source(source)),
        cols.words("range", "{confidence}", cols.interval(track=Track.WORDS, source=ALL), PAGE),
    ),
)


def _overview_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Order the entries whose arms are all controls last."""
    is_control = rates.groupby("title")["control"].transform("min")
    return rates.assign(of_controls=is_control).sort_values("of_controls", kind="stable")


def _overview_columns(rates: pd.DataFrame, settings: Settings) -> tuple[Column, ...]:
    short = {Kind.STATIC: "static", Kind.EMBODIED: "driving"}
    shown = rates[["split", "kind"]].drop_duplicates().itertuples(index=False)
    return (
        cols.words("system", value=cols.get("title")),
        *(
            cols.numbers(f"{split}_{kind}", f"{split}, {short[Kind(kind)]}", cols.three, cols.get("rate", split=split, kind=kind))
            for split, kind in shown
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
    wide=False,
)


def _write_signed_range(group: Group) -> str:
    low, high = group.get("low"), group.get("high")
    return "" if low is None else f"{cols.signed(low)} to {cols.signed(high)}"


TABLES["ranks"] = TableSpec(
    caption=(
        "Whether two splits rank the systems alike: Kendall's tau-b between the success rates of all systems that both splits "
        "have, controls, ablations and oracles aside. 1: the same order; 0: no relation. Ranges are {confidence} intervals when "
        "the scenes of both splits are resampled."
    ),
    columns=(
        *cols.labels("split", "other"),
        cols.words("judged", value=cols.judged),
        cols.numbers("systems"),
        cols.numbers("tau", "tau", cols.signed),
        *(cols.numbers(end, data=cols.signed, formats=DATA) for end in cols.INTERVAL),
        cols.words("range", "{confidence}", _write_signed_range, PAGE),
    ),
    wide=False,
)

SHOWN_COVERAGES = (0.25, 0.5, 0.75, 1.0)

TABLES["coverage"] = TableSpec(
    caption=(
        "Success on the static gate where an agent answers only the episodes of which it is surest, by coverage, the share of "
        "the episodes that are answered. Least confidence: of the answers that are given, as the agent itself holds them. "
        "Ranges are Wilson {confidence} intervals."
    ),
    rows=lambda rates, settings: rates[rates["coverage"].isin(SHOWN_COVERAGES)],
    section=lambda group: f"{group.get('split')}, {cols.of_arm('system')(group)}",
    columns=(
        cols.words("split", formats=CSV_AND_MARKDOWN),
        cols.words("system", value=cols.of_arm("system"), formats=CSV_AND_MARKDOWN),
        cols.words("arm", formats=DATA),
        *cols.rates("coverage"),
        cols.numbers("answered"),
        *cols.rates(least_confidence="least confidence"),
        cols.numbers("successes"),
        *cols.rates(rate="success"),
        cols.RANGE,
    ),
    wide=False,
)
