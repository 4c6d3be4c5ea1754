"""Draw success rates: by relation and memory, by difficulty, of agents against controls, and by coverage."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from ovman.report.figures.canvas import (
    ABOVE,
    AMBER,
    COLUMN_IN,
    DARK,
    INK,
    LIGHT,
    PALE,
    SMALL_PT,
    draw_bar,
    frame_rates,
    mark_paper,
    open_canvas,
    set_heading,
    strip_frame,
)
from ovman.report.metrics import Metrics, Missing
from ovman.report.tables.columns import RELATIONS
from ovman.settings import Kind, Settings, Withheld

SUCCESS = "success, static gate"
ENDS = ["rate", "low", "high"]
PANELS = (
    ("reference agent,\nown grounding", "maintained", "two", "maintained"),
    ("DualMap,\nown grounding", "dualmap_one", "dualmap_two", "dualmap_one"),
    ("reference agent,\noracle grounding", "grounding_maintained", "grounding_two", "grounding_one"),
    ("DualMap,\noracle grounding", "grounding_dualmap_one", "grounding_dualmap_two", "grounding_dualmap_one"),
)
"""Title, rows of the paper of the arm that reads one state and of the one that reads two visits, and the row with the paper's
figures for the former. The paper has none of one map with our own grounding: its row "single visit" is another arm."""


def draw_memory(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw success by relation, one maintained map against two visits (the paper's Fig. memory), diamonds being the paper's.

    The reference agent's maps are on the left and DualMap's on the right, with own grounding above and oracle grounding below.
    """
    with open_canvas(output) as plt:
        figure, axes = plt.subplots(2, 2, figsize=(COLUMN_IN, 3.5), sharex=True, sharey=True, layout="constrained")
        for axis, letter, (title, one, two, printed) in zip(axes.flat, "abcd", PANELS, strict=True):
            _draw_relations(axis, metrics, -0.2, f"static.{one}", f"static.{printed}", LIGHT, ("one maintained map", None))
            _draw_relations(axis, metrics, 0.2, f"static.{two}", f"static.{two}", DARK, ("two visits", "paper"))
            axis.set_xticks(range(len(RELATIONS)), RELATIONS, rotation=90)
            set_heading(axis, letter, title)
            frame_rates(axis, SUCCESS if letter in "ac" else None)
        handles, words = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, words, frameon=False, handlelength=1.2, loc="outside upper center", ncols=3)


def _draw_relations(
    axis: Any, metrics: Metrics, offset: float, row: str, printed: str, colour: str, words: tuple[str, str | None]
) -> None:
    """Draw the bars of an arm and the paper's diamonds. words: of both in the legend."""
    for place, relation in enumerate(RELATIONS):
        of_bar, of_diamond = words if place == 0 else (None, None)
        try:
            rows = metrics.rows("static_rates", arm=row, relation=relation)
            rate, low, high = (rows.one(column) for column in ENDS)
            draw_bar(axis, place + offset, (rate, low, high), 0.38, colour, of_bar)
        except Missing:
            pass
        mark_paper(axis, place + offset, f"{printed}.{relation}", of_diamond)


def draw_difficulty(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw success by the number of instances of the category and by scene (the paper's Fig. difficulty).

    (a) has the arms of comparisons.difficulty with intervals, diamonds being the paper's agent; (b) the agent as bars with
    intervals and, as dots, the other arms that pick nothing at random.
    """
    rows = metrics.frame("difficulty").dropna(subset=ENDS)
    with open_canvas(output) as plt:
        figure, (above, below) = plt.subplots(2, 1, figsize=(COLUMN_IN, 3.6), layout="constrained", height_ratios=[1, 1.15])
        set_heading(above, "a", "by instances of the category")
        set_heading(below, "b", "by scene")
        _draw_instances(above, rows[rows["by"] == "instances"], settings)
        _draw_scenes(below, rows[rows["by"] == "scene"], settings)
        handles, words = above.get_legend_handles_labels()
        figure.legend(handles, words, frameon=False, handlelength=1.2, loc="outside upper center", ncols=2)


def _draw_instances(axis: Any, rows: pd.DataFrame, settings: Settings, width: float = 0.27) -> None:
    printed = {"2": "success_with_two", "3": "success_with_three", "4+": "success_with_more"}
    groups, arms = rows.drop_duplicates("group"), list(_difficulty_arms(rows, settings))
    for place, group in enumerate(groups["group"]):
        for index, (arm, title, colour) in enumerate(arms):
            at = place + (index - (len(arms) - 1) / 2) * width
            for ends in _read_ends(rows, arm, group):
                draw_bar(axis, at, ends, width - 0.02, colour, title if place == 0 else None)
            if arm == settings.comparisons.agent:
                mark_paper(axis, at, printed.get(group, ""), "paper" if place == 0 else None)
    words = [f"{group} instances\n({n} episodes)" for group, n in zip(groups["group"], groups["n"], strict=True)]
    axis.set_xticks(range(len(groups)), words)
    frame_rates(axis, SUCCESS)


def _draw_scenes(axis: Any, rows: pd.DataFrame, settings: Settings) -> None:
    # From the hardest scene to the easiest; of equal ones by name.
    agent = rows[rows["arm"] == settings.comparisons.agent]
    order = agent.sort_values(["rate", "group"], kind="stable")["group"].to_list()
    for arm, title, colour in _difficulty_arms(rows, settings):
        if settings.arms[arm].expected:
            continue
        for place, scene in enumerate(order):
            for ends in _read_ends(rows, arm, scene):
                if arm == settings.comparisons.agent:
                    draw_bar(axis, place, ends, 0.7, colour)
                else:
                    axis.plot(place, ends[0], "o", color=colour, markersize=3, zorder=4, label=title if place == 0 else None)
    axis.set_xticks(range(len(order)), [scene.removeprefix("FloorPlan") for scene in order], rotation=90, fontsize=SMALL_PT)
    axis.set_xlabel("floor plan")
    axis.legend(**ABOVE)
    axis.set_xlim(-0.6, len(order) - 0.4)
    frame_rates(axis, SUCCESS)


def _difficulty_arms(rows: pd.DataFrame, settings: Settings) -> Iterator[tuple[str, str, str]]:
    """Yield the arms with rows: name, title and colour."""
    arms = [arm for arm in settings.comparisons.difficulty if arm in {*rows["arm"]}]
    for index, arm in enumerate(arms):
        yield arm, settings.comparisons.difficulty[arm], (LIGHT, DARK, AMBER)[index % 3]


def _read_ends(rows: pd.DataFrame, arm: str, group: str) -> list[list[float]]:
    return rows.loc[(rows["arm"] == arm) & (rows["group"] == group), ENDS].to_numpy().tolist()


CHANCE = "chance among what changed"
"""Title of the row of column chance_of_change: a random pick of the changes of the kind that defines the episode."""
AGENTS, CONTROLS = "agents", "controls"


def draw_controls(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw two dots with intervals per arm of comparisons.controls: static success on the first split and in homes.

    Controls that are asked about another noun, relation or visit are left to the table.
    """
    rows = _read_controls(metrics, settings)
    splits = list(dict.fromkeys(rows["split"]))
    homes = [name for name in splits if settings.splits[name].homes is not None]
    ends = list(dict.fromkeys((*splits[:1], *(homes or splits)[-1:])))
    rows = rows[rows["split"].isin(ends)]
    blocks = [block for name in (AGENTS, CONTROLS, "") if len(block := rows[rows["block"] == name])]
    lines = sum(1 + block["title"].nunique() for block in blocks)
    with open_canvas(output) as plt:
        _, axis = plt.subplots(figsize=(COLUMN_IN, max(2.0, 0.6 + 0.235 * lines)), layout="constrained")
        axis.set_xlabel("success on the static gate, all relations")
        axis.set_xlim(-0.14, 1.18)
        axis.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1.0])
        strip_frame(axis, "x", pad=3)
        place, ticks = 0.0, []
        for block, colour in zip(blocks, (DARK, AMBER, INK), strict=False):
            heading = block["block"].iloc[0]
            if heading:
                ticks.append((place, heading))
            else:
                place -= 0.5
            for title in dict.fromkeys(block["title"]):
                place += 1
                _draw_dots(axis, place, block[block["title"] == title], ends, colour)
                ticks.append((place, title))
            place += 1
        axis.set_yticks([at for at, _ in ticks], [title for _, title in ticks])
        for label in axis.get_yticklabels():
            label.set_fontstyle("italic" if label.get_text() in (AGENTS, CONTROLS) else "normal")
        axis.set_ylim(place - 0.4, -0.6)
        for face, split in zip(("white", INK)[-len(ends) :], ends, strict=True):
            axis.plot([], [], "o", markerfacecolor=face, markeredgecolor=INK, markersize=4.2, label=f"split {split}")
        axis.legend(**(ABOVE | {"ncols": 2, "handlelength": 0.8}))


def _read_controls(metrics: Metrics, settings: Settings) -> pd.DataFrame:
    """Return the rows of the figure, those with the highest rate on the first split first."""
    rows = metrics.rows("controls", kind=Kind.STATIC).frame
    arms = rows[[settings.arms[arm].withheld in (None, Withheld.NOUN) for arm in rows["arm"]]]
    arms = arms.assign(
        block=arms["control"].map({0: AGENTS, 1: CONTROLS}),
        title=[settings.comparisons.controls[arm].title or settings.arms[arm].system for arm in arms["arm"]],
    )
    of_splits = rows.drop_duplicates("split")
    chances = of_splits.assign(block="", title=CHANCE, **dict.fromkeys(ENDS, of_splits["chance_of_change"]))
    found = pd.concat([arms, chances])[["split", "block", "title", *ENDS]].astype(dict.fromkeys(ENDS, float))
    first = found.drop_duplicates("title").set_index("title")["rate"]
    return found.iloc[(-found["title"].map(first)).argsort(kind="stable")]


def _draw_dots(axis: Any, place: float, rows: pd.DataFrame, ends: list[str], colour: str) -> None:
    """Draw the dots of one row with their intervals: hollow on the first split, filled on the last."""
    of_split = {split: row for split, *row in rows[["split", *ENDS]].to_numpy().tolist()}
    rates = [rate for rate, *_ in of_split.values()]
    axis.plot((min(rates), max(rates)), (place, place), color=PALE, linewidth=2.4, solid_capstyle="butt", zorder=1)
    for number, split in enumerate(ends):
        if split not in of_split:
            continue
        rate, low, high = of_split[split]
        is_last = number == len(ends) - 1
        at = place + (0.15 if is_last else -0.15)
        axis.plot((low, high), (at, at), color=colour, linewidth=0.8, zorder=2)
        face = colour if is_last else "white"
        axis.plot(rate, at, "o", markersize=4.2, markerfacecolor=face, markeredgecolor=colour, markeredgewidth=1.0, zorder=3)
        right = rate > min(rates) or len(set(rates)) == 1
        edge, offset = ((high, at), (3, 0)) if right else ((low, at), (-3, 0))
        style = {"textcoords": "offset points", "va": "center", "ha": "left" if right else "right", "fontsize": SMALL_PT}
        axis.annotate(f"{rate:.3f}", edge, offset, **style)


def draw_coverage(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw success by coverage, one line with its interval per split and agent: what an agent reaches where it is surest."""
    styles = ((DARK, "-"), (AMBER, "-"), (INK, "--"), (DARK, ":"), (AMBER, ":"))
    lines = metrics.frame("coverage").groupby(["split", "arm"], sort=False)
    with open_canvas(output) as plt:
        _, axis = plt.subplots(figsize=(COLUMN_IN, 2.2), layout="constrained")
        for number, ((split, arm), line) in enumerate(lines):
            colour, dashes = styles[number % len(styles)]
            label = f"{settings.arms[str(arm)].system}, split {split}"
            axis.plot(line["coverage"], line["rate"], color=colour, linestyle=dashes, linewidth=1.2, label=label)
            axis.fill_between(line["coverage"], line["low"], line["high"], color=colour, alpha=0.12, linewidth=0)
        axis.legend(frameon=False, fontsize=SMALL_PT, loc="lower left")
        frame_rates(axis, "success among the answers")
        axis.set_xlim(0, 1)
        axis.set_xticks([0.2, 0.4, 0.6, 0.8, 1.0])
        axis.set_xlabel("coverage (share of episodes answered, surest first)")


RUNGS = ("two_visits", "joint", "joint_true_names", "joint_true_boxes", "joint_true_identity", "joint_true_names_and_identity")
"""Arms of the figure of rungs, in its order. The ideal observer follows."""
OBSERVER = "ideal_observer"


def draw_rungs(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw static success of the joint agent with one part replaced by the truth, one panel per split with an ideal observer."""
    rows = metrics.rows("overview", kind=Kind.STATIC).frame
    splits = rows.loc[rows["arm"] == OBSERVER, "split"].to_list()
    if not splits:
        raise Missing(f"overview.csv has no row of {OBSERVER}")
    arms = [arm for arm in (*RUNGS, OBSERVER) if arm in settings.arms]
    with open_canvas(output) as plt:
        size = (COLUMN_IN, 0.5 + 0.2 * len(arms))
        _, axes = plt.subplots(1, len(splits), figsize=size, sharey=True, squeeze=False, layout="constrained")
        for axis, split in zip(axes[0], splits, strict=True):
            of_arm = rows[rows["split"] == split].set_index("arm")
            for place, arm in enumerate(arms):
                if arm in of_arm.index:
                    _draw_rung(axis, place, of_arm.loc[arm, ENDS].astype(float).to_list(), DARK if arm in RUNGS[:2] else LIGHT)
            axis.set_title(f"split {split}", loc="left")
            axis.set_xlim(0, 1.25)
            axis.set_xticks([0, 0.5, 1.0])
            strip_frame(axis, "x", pad=3)
        axes[0, 0].set_yticks(range(len(arms)), [settings.arms[arm].system for arm in arms])
        axes[0, 0].invert_yaxis()
        axes[0, 0].set_xlabel("success on the static gate, all relations")


def _draw_rung(axis: Any, place: int, ends: list[float], colour: str) -> None:
    """Draw a bar from the left with its interval and its rate in digits."""
    rate, low, high = ends
    axis.barh(place, rate, 0.7, color=colour, zorder=2)
    axis.plot((low, high), (place, place), color=INK, linewidth=0.6, zorder=3)
    axis.annotate(f"{rate:.3f}", (max(rate, high), place), (2, 0), textcoords="offset points", va="center", fontsize=SMALL_PT)
