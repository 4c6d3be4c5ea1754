"""The table of constants, read from the settings that are in force."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any

from ovman.models.settings import Settings
from ovman.report.table import DATA, Column, Row, Table, Text, Words


@dataclass(frozen=True, slots=True)
class Shown:
    """One constant of the table. key: its place in config.yaml; symbol: the paper's, None where it has none."""

    key: str
    symbol: Text | None
    meaning: str
    unit: str


SHOWN: tuple[Shown, ...] = (
    Shown("tour.waypoints", Text("W", "$W$"), "waypoints per tour", ""),
    Shown("tour.headings", None, "headings per waypoint", ""),
    Shown("success.radius_m", Text("R", "$R$"), "success radius", "m"),
    Shown("candidates.delta_min_m", Text("Δ_min", r"$\Delta_{\min}$"), "minimum applied displacement", "m"),
    Shown("association.gate_m", Text("γ", r"$\gamma$"), "association gate", "m"),
    Shown("association.feature_scale_m", Text("λ", r"$\lambda$"), "feature-disagreement scale", "m"),
    Shown("admissibility.tau_m", Text("τ", r"$\tau$"), "moved / stable displacement threshold", "m"),
    Shown("association.track_spread_m", Text("τ_trk", r"$\tau_{\mathrm{trk}}$"), "moving track-spread threshold", "m"),
    Shown("grounding.similarity_margin", Text("δ_g", r"$\delta_{\mathrm{g}}$"), "grounding band below the best similarity", ""),
    Shown("maps.cluster_radius_m", Text("ε", r"$\epsilon$"), "instance clustering radius", "m"),
    Shown("perception.detector.confidence", None, "detector confidence", ""),
    Shown("perception.detector.min_mask_px", None, "smallest detected mask", "px"),
    Shown("admissibility.motion_m", None, "distance between two positions that counts as motion", "m"),
    Shown("admissibility.min_mask_px", None, "smallest recorded instance mask", "px"),
    Shown("success.visible_px", None, "smallest mask that counts as visible at the stop", "px"),
    Shown("success.sweep_deg", None, "look-down sweep at the stop", "°"),
    Shown("primitives.step_m", None, "step of the agent", "m"),
    Shown("primitives.turn_deg", None, "turn of the agent", "°"),
    Shown("primitives.heading_tolerance_deg", None, "heading tolerance", "°"),
    Shown("primitives.action_budget", None, "action budget", "actions"),
    Shown("primitives.stop_within_m", None, "the agent stops within", "m"),
    Shown("primitives.blocked_edge_expiry", None, "expiry of a blocked edge (MOVING)", "actions"),
    Shown("primitives.stall_after", None, "stall: no successful move for", "actions"),
    Shown("admissibility.validity_radius_m", None, "validity radius", "m"),
    Shown("candidates.spawn_clearance_m", None, "spawn clearance", "m"),
    Shown("admissibility.drift_tolerance_m", None, "drift tolerance", "m"),
    Shown("admissibility.runs", None, "certification runs after the feasibility run", ""),
    Shown("mover.step_m", None, "mover step per agent action", "m"),
    Shown("mover.lane_min_m", None, "shortest lane of a mover", "m"),
    Shown("mover.pause_probability", None, "mover pauses, per agent action", ""),
    Shown("mover.turn_probability", None, "mover turns back early, per agent action", ""),
    Shown("single_visit.samples", None, "Monte Carlo draws of the single-visit baseline", ""),
)

KEYS: tuple[str, ...] = tuple(shown.key for shown in SHOWN)

_COLUMNS = (
    Column("symbol", "symbol"),
    Column("meaning", "meaning"),
    Column("value", "value", numeric=True),
    Column("unit", "unit"),
    Column("setting", "setting", formats=DATA),
)


def constants_table(constants: Settings) -> Table:
    """Symbol, meaning, value and unit of every constant that the benchmark and the reference agent use today.

    constants: an object whose attributes follow ``KEYS``, for instance constants.tour.waypoints.
    """
    return Table(
        name="constants",
        caption="Constants of the benchmark and the reference agent, as read from the settings in force.",
        columns=_COLUMNS,
        rows=tuple(_row(shown, reduce(getattr, shown.key.split("."), constants)) for shown in SHOWN),
    )


def _row(shown: Shown, value: Any) -> Row:
    cells: dict[str, Words] = {
        "meaning": shown.meaning,
        "value": value_text(value, shown.unit),
        "unit": shown.unit,
        "setting": shown.key,
    }
    return Row(cells | ({"symbol": shown.symbol} if shown.symbol else {}))


def value_text(value: Any, unit: str) -> str:
    """Metres keep a decimal (1.0, 0.25), everything else is as short as it is exact; commas set off the members of a list."""
    if isinstance(value, list | tuple):
        return ", ".join(value_text(member, unit) for member in value)
    return str(float(value)) if unit == "m" else f"{value:.12g}"
