"""The files of results/metrics, once: which stage makes each, which table shows it, and who else reads it.

The rules of the workflow, the stages, the tables and the comparison with the paper derive their lists from `METRICS`. The
Snakefile imports this module, so it imports nothing heavy.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ovman.models.settings import Arm, Need


@dataclass(frozen=True, slots=True)
class Metric:
    """One file of metrics. name: its stem. stage: the stage that makes it.

    table: the table that shows it, None where none does. static: it follows from predictions alone, so `static_tables` shows it.
    compared: the comparison with the paper reads it. need: it is made only where an arm has this need.
    """

    name: str
    stage: str = "metrics"
    table: str | None = None
    static: bool = False
    compared: bool = False
    need: Need | None = None

    @property
    def file(self) -> str:
        """The name of the file."""
        return f"{self.name}.csv"


METRICS: tuple[Metric, ...] = (
    Metric("static_outcomes"),
    Metric("embodied_outcomes"),
    Metric("static_rates", table="static", static=True, compared=True),
    Metric("embodied_rates", table="embodied", compared=True),
    Metric("rejections", stage="episodes", table="rejections"),
    Metric("taxonomy", table="taxonomy", static=True, compared=True),
    Metric("significance", table="significance", compared=True),
    Metric("navigation", table="navigation", compared=True),
    Metric("difficulty", table="difficulty", static=True, compared=True),
    Metric("budget", table="budget", static=True, compared=True),
    Metric("pairings", table="pairings", static=True, compared=True),
    Metric("own_task", table="own_task", compared=True),
    Metric("seeds", table="seeds", compared=True),
    Metric("scenes", table="scenes"),
    Metric("language", stage="language", table="language", compared=True),
    Metric("perception", stage="perception", table="perception", compared=True),
    Metric("backprojection", stage="backprojection", table="backprojection", compared=True),
    Metric("dualmap", stage="dualmap_objects", table="dualmap", compared=True, need=Need.DUALMAP),
)


def of_stage(stage: str) -> tuple[str, ...]:
    """The names of the metrics that a stage makes."""
    return tuple(metric.name for metric in METRICS if metric.stage == stage)


def in_tables(arms: Iterable[Arm]) -> tuple[str, ...]:
    """The names of the metrics that tables show, of those that are made for these arms."""
    return tuple(metric.name for metric in _made_for(arms) if metric.table is not None)


def in_static_tables() -> tuple[str, ...]:
    """The names of the metrics that the tables of the static arms alone show."""
    return tuple(metric.name for metric in METRICS if metric.static)


def compared(arms: Iterable[Arm]) -> tuple[str, ...]:
    """The names of the metrics that the comparison with the paper reads, of those that are made for these arms."""
    return tuple(metric.name for metric in _made_for(arms) if metric.compared)


def table_of(metric: str) -> str:
    """The name of the table that shows a metric. Raises ValueError for one that no table shows."""
    shown = {one.name: one.table for one in METRICS if one.table is not None}
    if metric not in shown:
        raise ValueError(f"no table shows {metric}; those that are shown are {', '.join(shown)}")
    return shown[metric]


def _made_for(arms: Iterable[Arm]) -> list[Metric]:
    needs = {need for arm in arms for need in arm.needs}
    return [metric for metric in METRICS if metric.need is None or metric.need in needs]
