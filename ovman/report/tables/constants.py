"""The table of constants, read from the settings that are in force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import pandas as pd

from ovman.report.tables.columns import numbers, words
from ovman.report.tables.table import DATA, Column, Table
from ovman.settings import Settings


@dataclass(frozen=True, slots=True)
class Shown:
    """One constant of the table. key: its place in config.yaml; symbol: the paper's, "" where it has none."""

    key: str
    symbol: str
    meaning: str
    unit: str


SHOWN: tuple[Shown, ...] = (
    Shown("tour.waypoints", "W", "waypoints per tour", ""),
    Shown("tour.headings", "", "headings per waypoint", ""),
    Shown("success.radius_m", "R", "success radius", "m"),
    Shown("candidates.delta_min_m", "Δ_min", "minimum applied displacement", "m"),
    Shown("association.gate_m", "γ", "association gate", "m"),
    Shown("association.feature_scale_m", "λ", "feature-disagreement scale", "m"),
    Shown("admissibility.tau_m", "τ", "moved / stable displacement threshold", "m"),
    Shown("association.track_spread_m", "τ_trk", "moving track-spread threshold", "m"),
    Shown("grounding.similarity_margin", "δ_g", "grounding band below the best similarity", ""),
    Shown("maps.cluster_radius_m", "ε", "instance clustering radius", "m"),
    Shown("perception.detector.confidence", "", "detector confidence", ""),
    Shown("perception.detector.min_mask_px", "", "smallest detected mask", "px"),
    Shown("admissibility.motion_m", "", "distance between two positions that counts as motion", "m"),
    Shown("admissibility.mover_spread_m", "", "recorded places of one of several movers lie farther apart than", "m"),
    Shown("admissibility.min_mask_px", "", "smallest recorded instance mask", "px"),
    Shown("success.visible_px", "", "smallest mask that counts as visible at the stop", "px"),
    Shown("success.sweep_deg", "", "look-down sweep at the stop", "°"),
    Shown("primitives.step_m", "", "step of the agent", "m"),
    Shown("primitives.turn_deg", "", "turn of the agent", "°"),
    Shown("primitives.heading_tolerance_deg", "", "heading tolerance", "°"),
    Shown("primitives.action_budget", "", "action budget", "actions"),
    Shown("primitives.stop_within_m", "", "the agent stops within", "m"),
    Shown("primitives.blocked_edge_expiry", "", "expiry of a blocked edge (MOVING)", "actions"),
    Shown("primitives.stall_after", "", "stall: no successful move for", "actions"),
    Shown("admissibility.validity_radius_m", "", "validity radius", "m"),
    Shown("candidates.spawn_clearance_m", "", "spawn clearance", "m"),
    Shown("candidates.spawn_beyond_m", "", "a spawn is farther from where a stop succeeds than", "m"),
    Shown("admissibility.above_chance", "", "excess of a uniform pick over 1/n, at most", ""),
    Shown("candidates.crowding_m", "", "other instances are farther from the answer than", "m"),
    Shown("candidates.apart_m", "", "what else changes is from the answer and what is scripted", "m"),
    Shown("admissibility.drift_tolerance_m", "", "drift tolerance", "m"),
    Shown("admissibility.runs", "", "certification runs after the feasibility run", ""),
    Shown("mover.step_m", "", "mover step per agent action", "m"),
    Shown("mover.pause_probability", "", "mover pauses, per agent action", ""),
    Shown("mover.turn_probability", "", "mover turns unbarred, per agent action", ""),
    Shown("single_visit.samples", "", "Monte Carlo draws of the single-visit baseline", ""),
)

KEYS: tuple[str, ...] = tuple(shown.key for shown in SHOWN)

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
    """Symbol, meaning, value and unit of every constant that the benchmark and the reference agent use today."""
    rows = [
        {
            "symbol": shown.symbol,
            "meaning": shown.meaning,
            "value": value_text(reduce(getattr, shown.key.split("."), settings), shown.unit),
            "unit": shown.unit,
            "setting": shown.key,
        }
        for shown in SHOWN
    ]
    columns = (
        Column("symbol", "symbol", tex=SYMBOLS.__getitem__),
        words("meaning"),
        numbers("value"),
        words("unit"),
        words("setting", formats=DATA),
    )
    caption = "Constants of the benchmark and the reference agent, as read from the settings in force."
    return Table(caption, columns, pd.DataFrame(rows))


def value_text(value: Any, unit: str) -> str:
    """Metres keep a decimal (1.0, 0.25), everything else is as short as it is exact; commas set off the members of a list."""
    if isinstance(value, list | tuple):
        return ", ".join(value_text(member, unit) for member in value)
    return str(float(value)) if unit == "m" else f"{value:.12g}"
