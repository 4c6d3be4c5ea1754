"""Tables of the benchmark itself: its constants, prior work, and the audit of candidates."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from functools import reduce
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ovman.generation.audit import CERTIFIED, DRAWN, RELEASED
from ovman.records.task import Rejection, RejectionStage
from ovman.report.tables.columns import RELATIONS, get, numbers, of_relation, words
from ovman.report.tables.specs import TableSpec
from ovman.report.tables.table import ALL, DATA, Column, Group, Table
from ovman.settings import Settings, Split

TABLES: dict[str, TableSpec] = {}

# --- constants ------------------------------------------------------------------------------------

CONSTANTS: tuple[tuple[str, str, str, str], ...] = (
    ("tour.waypoints", "W", "waypoints per tour", ""),
    ("tour.headings", "", "headings per waypoint", ""),
    ("success.radius_m", "R", "success radius", "m"),
    ("candidates.delta_min_m", "Δ_min", "minimum applied displacement", "m"),
    ("association.gate_m", "γ", "association gate", "m"),
    ("association.feature_scale_m", "λ", "feature-disagreement scale", "m"),
    ("admissibility.tau_m", "τ", "moved / stable displacement threshold", "m"),
    ("association.track_spread_m", "τ_trk", "moving track-spread threshold", "m"),
    ("grounding.similarity_margin", "δ_g", "grounding band below the best similarity", ""),
    ("maps.cluster_radius_m", "ε", "instance clustering radius", "m"),
    ("perception.detector.confidence", "", "detector confidence", ""),
    ("perception.detector.min_mask_px", "", "smallest detected mask", "px"),
    ("admissibility.motion_m", "", "distance between two positions that counts as motion", "m"),
    ("admissibility.mover_spread_m", "", "recorded places of one of several movers lie farther apart than", "m"),
    ("admissibility.min_mask_px", "", "smallest recorded instance mask", "px"),
    ("success.visible_px", "", "smallest mask that counts as visible at the stop", "px"),
    ("success.sweep_deg", "", "look-down sweep at the stop", "°"),
    ("primitives.step_m", "", "step of the agent", "m"),
    ("primitives.turn_deg", "", "turn of the agent", "°"),
    ("primitives.heading_tolerance_deg", "", "heading tolerance", "°"),
    ("primitives.action_budget", "", "action budget", "actions"),
    ("primitives.stop_within_m", "", "the agent stops within", "m"),
    ("primitives.blocked_edge_expiry", "", "expiry of a blocked edge (MOVING)", "actions"),
    ("primitives.stall_after", "", "stall: no successful move for", "actions"),
    ("admissibility.validity_radius_m", "", "validity radius", "m"),
    ("candidates.spawn_clearance_m", "", "spawn clearance", "m"),
    ("candidates.spawn_beyond_m", "", "a spawn is farther from where a stop succeeds than", "m"),
    ("admissibility.above_chance", "", "excess of a uniform pick over 1/n, at most", ""),
    ("candidates.crowding_m", "", "other instances are farther from the answer than", "m"),
    ("candidates.apart_m", "", "what else changes is from the answer and what is scripted", "m"),
    ("admissibility.drift_tolerance_m", "", "drift tolerance", "m"),
    ("admissibility.runs", "", "certification runs after the feasibility run", ""),
    ("mover.step_m", "", "mover step per agent action", "m"),
    ("mover.pause_probability", "", "mover pauses, per agent action", ""),
    ("mover.turn_probability", "", "mover turns unbarred, per agent action", ""),
    ("single_visit.samples", "", "Monte Carlo draws of the single-visit baseline", ""),
)
"""Place in config.yaml, symbol of the paper, meaning, unit."""
SYMBOLS: Mapping[str, str] = {
    "W": "$W$",
    "R": "$R$",
    "Δ_min": r"$\Delta_{\min}$",
    "γ": r"$\gamma$",
    "λ": r"$\lambda$",
    "τ": r"$\tau$",
    "τ_trk": r"$\tau_{\mathrm{trk}}$",
    "δ_g": r"$\delta_{\mathrm{g}}$",
    "ε": r"$\epsilon$",
}
"""LaTeX of the symbols."""


def constants_table(settings: Settings) -> Table:
    """Make the table of every constant that the benchmark and the reference agent use."""
    names = ("setting", "symbol", "meaning", "unit")
    rows = [dict(zip(names, constant, strict=True)) for constant in CONSTANTS]
    for row in rows:
        row["value"] = value_text(reduce(getattr, row["setting"].split("."), settings), row["unit"])
    columns = (
        Column("symbol", "symbol", tex=SYMBOLS.__getitem__),
        words("meaning"),
        numbers("value"),
        words("unit"),
        words("setting", formats=DATA),
    )
    caption = "Constants of the benchmark and the reference agent, as read from the settings in force."
    return Table(caption, columns, tuple(Group([row], settings) for row in rows))


def value_text(value: Any, unit: str) -> str:
    """Write metres with a decimal (1.0, 0.25), everything else as short as it is exact, and the members of a list."""
    if isinstance(value, list | tuple):
        return ", ".join(value_text(member, unit) for member in value)
    return str(float(value)) if unit == "m" else f"{value:.12g}"


# --- prior work -----------------------------------------------------------------------------------

POSITION = Path(__file__).with_name("position.yaml")


class Has(StrEnum):
    """Whether a work has a property."""

    YES = "yes"
    PARTLY = "partly"
    NO = "no"


class Work(BaseModel):
    """One row, or two works that agree in all. remark: next to the last property."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    work: Annotated[str, Field(min_length=1)]
    both_visits: Has
    open_vocabulary: Has
    change_relation: Has
    empty_past: Has
    remark: str | None = None


class Position(BaseModel):
    """The rows in the order of the paper. source: where they are printed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    source: Annotated[str, Field(min_length=1)]
    rows: tuple[Work, ...]


def position_table(settings: Settings, path: Path = POSITION) -> Table:
    """Make the paper's Table "position" from a file. ValueError in one line with the file and the key."""
    try:
        position = Position.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        wrong = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, wrong['loc']))}: {wrong['msg']}") from None
    columns = (
        words("work"),
        words("both_visits", "two visits"),
        words("open_vocabulary", "open vocabulary"),
        words("change_relation", "goal by change relation"),
        words("empty_past", "empty past locations", _empty_past),
    )
    caption = "The benchmark against the closest prior work. No single column is new; no other row has all four. "
    groups = (Group([one.model_dump(mode="json")], settings) for one in position.rows)
    return Table(f"{caption}Source: {position.source}.", columns, tuple(groups))


def _empty_past(group: Group) -> str:
    remark = group.get("remark")
    return f"{group.get('empty_past')} ({remark})" if remark else str(group.get("empty_past"))


# --- the audit of candidates, and splits ----------------------------------------------------------

TOTALS = (DRAWN, CERTIFIED, RELEASED)
"""Stages without a reason."""


def _rejection_rows(counts: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """List every reason that rejected something in the order of the checks, drawn above, certified and released below.

    Raises:
        ValueError: A relation, stage or reason does not exist, a line occurs twice, or drawn is not rejected plus certified.
    """
    counts = counts.assign(reason=counts["reason"].fillna(""))
    for wrong in counts.loc[~counts["relation"].isin(RELATIONS), "relation"]:
        raise ValueError(f"rejections: {wrong!r} is not a change relation")
    for row in counts[counts.duplicated(["relation", "stage", "reason"])].itertuples():
        raise ValueError(f"rejections: {row.relation}, {row.stage} {row.reason} is counted twice")
    table = counts.pivot(index=["stage", "reason"], columns="relation", values="count").fillna(0).astype(int)
    reasons = [(reason.stage.value, reason.value) for stage in RejectionStage for reason in Rejection if reason.stage is stage]
    known = [(DRAWN, ""), *reasons, (CERTIFIED, ""), (RELEASED, "")]
    if strangers := sorted({*table.index} - {*known}):
        raise ValueError(f"rejections: {' '.join(strangers[0]).strip()!r} is neither a stage with its reason nor a total")
    table = table.reindex(index=pd.MultiIndex.from_tuples(known, names=table.index.names), columns=RELATIONS, fill_value=0)
    for relation in RELATIONS:
        drawn, certified, released = (int(table[relation][stage, ""]) for stage in TOTALS)
        rejected = int(table[relation].sum()) - drawn - certified - released
        if drawn != rejected + certified:
            raise ValueError(f"rejections: {relation} has {drawn} drawn, but {rejected} rejected and {certified} certified")
        if released > certified:
            raise ValueError(f"rejections: {relation} has {released} released of {certified} certified")
    table[ALL] = table.sum(axis=1)
    return table[(table[ALL] > 0) | table.index.get_level_values("stage").isin(TOTALS)].reset_index()


TABLES["rejections"] = TableSpec(
    caption="Audit of the candidates: first reason of rejection by relation, in the order of the checks.",
    rows=_rejection_rows,
    columns=(
        words("stage"),
        words("reason"),
        *(of_relation(relation, data=str, value=get(relation)) for relation in (*RELATIONS, ALL)),
    ),
    wide=True,
)


def describe_split(split: Split) -> str:
    """Say in words how a split differs from the paper's protocol."""
    says = []
    if not split.single:
        changes = " or ".join(map(str, split.changes))
        says.append(f"{changes} instances of the queried category change, each under another relation")
    if split.others is not None:
        fewest, most = split.others.count
        number = f"{fewest}" if fewest == most else f"{fewest} to {most}"
        says.append(f"{number} instances of other categories change as well")
    own = [what for what, has in (("views", split.second_tour), ("light", split.light)) if has is not None]
    if own:
        says.append(f"the second tour has {' and '.join(own)} of its own")
    if split.sensors is not None:
        says.append(f"depth and poses err (sensors: {split.sensors})")
    return "; ".join(says) or "the paper's protocol"
