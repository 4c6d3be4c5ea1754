"""The paper's Fig. diag: (a) the error budget, (b) static success against the association gate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ovman.models.settings import Settings
from ovman.report.figures.budget import rungs
from ovman.report.figures.canvas import ABOVE, AMBER, COLUMN_IN, DARK, INK, LIGHT, absent, drawing, framed, lettered
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.report.paper_comparison.paper import Paper


def draw(metrics: Metrics, paper: Paper, settings: Settings, output: Path) -> None:
    """Write both parts; gates are in metres, the one in force and Delta_min, which it must not reach, are marked."""
    with drawing(output) as plt:
        _, (above, below) = plt.subplots(2, 1, figsize=(COLUMN_IN, 3.3), layout="constrained", height_ratios=[1.2, 1])
        lettered(above, "a", "error budget")
        rungs(above, metrics, paper, settings)
        lettered(below, "b", "association gate")
        _gates(below, metrics)


def _gates(axis: Any, metrics: Metrics) -> None:
    axis.set_xlabel("gate γ in metres")
    framed(axis, "success, static gate")
    try:
        rows = metrics.frame("gate_sweep")
    except Missing as missing:
        absent(axis, str(missing))
        return
    in_force = rows[rows["in_force"] == "1"]
    rows = rows[["gate_m", "success", "low", "high"]].astype(float).sort_values("gate_m", kind="stable")
    axis.fill_between(rows["gate_m"], rows["low"], rows["high"], color=LIGHT, alpha=0.6, linewidth=0, zorder=2)
    axis.plot(rows["gate_m"], rows["success"], color=DARK, linewidth=1.2, marker="o", markersize=2.2, zorder=3)
    for gate_m, delta_min_m in in_force[["gate_m", "delta_min_m"]].astype(float).to_numpy().tolist():
        axis.axvline(gate_m, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), label="in force", zorder=4)
        axis.axvline(delta_min_m, color=AMBER, linewidth=1.0, label=r"$\Delta_{\min}$", zorder=4)
    if len(in_force):
        axis.legend(ncols=2, **ABOVE)
