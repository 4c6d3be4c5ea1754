"""Tables of the benchmark itself: its constants, prior work, and the audit of candidates."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from ovman.records.task import CERTIFIED, DRAWN, RELEASED, Rejection, RejectionStage
from ovman.report.tables import columns as cols
from ovman.report.tables.table import ALL, DATA, Column, Group, Table, TableSpec
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
    ("admissibility.mover_spread_m", "", "recorded places of a mover lie farther apart than", "m"),
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
        cols.words("meaning"),
        cols.numbers("value"),
        cols.words("unit"),
        cols.words("setting", formats=DATA),
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


def position_table(settings: Settings) -> Table:
    """Make the paper's Table "position"."""
    position = yaml.safe_load(POSITION.read_text(encoding="utf-8"))
    columns = (
        *cols.labels("work", both_visits="two visits", open_vocabulary="open vocabulary"),
        cols.words("change_relation", "goal by change relation"),
        cols.words("empty_past", "empty past locations", _empty_past),
    )
    caption = "The benchmark against the closest prior work. No single column is new; no other row has all four. "
    return Table(f"{caption}Source: {position['source']}.", columns, tuple(Group([row], settings) for row in position["rows"]))


def _empty_past(group: Group) -> str:
    remark = group.get("remark")
    return f"{group.get('empty_past')} ({remark})" if remark else str(group.get("empty_past"))


# --- the audit of candidates, and splits ----------------------------------------------------------

TOTALS = (DRAWN, CERTIFIED, RELEASED)
"""Stages without a reason."""


def rejection_rows(counts: pd.DataFrame) -> pd.DataFrame:
    """List every reason that rejected something in the order of the checks, drawn above, certified and released below.

    Raises:
        ValueError: A reason occurs twice or does not exist, or drawn is not rejected plus certified.
    """
    reason = counts["reason"].astype("string").fillna("")  # without any rejection the column has no words
    table = counts.assign(reason=reason).pivot(index=["stage", "reason"], columns="relation", values="count")
    reasons = [(reason.stage.value, reason.value) for stage in RejectionStage for reason in Rejection if reason.stage is stage]
    known = pd.MultiIndex.from_tuples([(DRAWN, ""), *reasons, (CERTIFIED, ""), (RELEASED, "")], names=table.index.names)
    table = table.reindex(index=known, columns=cols.RELATIONS).fillna(0).astype(int)
    stages: Any = [table.loc[(stage, "")] for stage in TOTALS]
    drawn, certified, released = stages
    rejected = table.sum() - drawn - certified - released
    for relation in cols.RELATIONS:
        if drawn[relation] != rejected[relation] + certified[relation] or released[relation] > certified[relation]:
            raise ValueError(
                f"rejections: {relation} has {drawn[relation]} drawn, {rejected[relation]} rejected, "
                f"{certified[relation]} certified and {released[relation]} released, which do not add up"
            )
    table[ALL] = table.sum(axis=1)
    return table[(table[ALL] > 0) | table.index.get_level_values("stage").isin(TOTALS)].reset_index()


TABLES["rejections"] = TableSpec(
    caption="Audit of the candidates: first reason of rejection by relation, in the order of the checks.",
    rows=lambda counts, settings: rejection_rows(counts),
    columns=(
        *cols.labels("stage", "reason"),
        *(cols.of_relation(relation, data=str, value=cols.get(relation)) for relation in (*cols.RELATIONS, ALL)),
    ),
)


def describe_split(split: Split) -> str:
    """Say in words how a split differs from the paper's protocol."""
    says = []
    if split.changes != (1,):
        changes = " or ".join(map(str, split.changes))
        says.append(f"{changes} instances of the queried category change, each under another relation")
    if split.crossed is not None:
        fewest, most = split.crossed.queries
        says.append(f"several things of several categories change, and {fewest} to {most} queries are asked about them")
    own = [what for what, has in (("views", split.second_tour), ("light", split.light)) if has is not None]
    if own:
        says.append(f"the second tour has {' and '.join(own)} of its own")
    if split.sensors is not None:
        says.append(f"depth and poses err (sensors: {split.sensors})")
    return "; ".join(says) or "the paper's protocol"
