"""The files of results/metrics, once: which stage makes each, which table shows it, and who else reads it.

The rules of the workflow, the stages, the tables and the comparison with the paper derive their lists from `METRICS`. The
Snakefile imports this module, so it imports nothing heavy.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ovman.settings import Arm, Kind, Need, Split


@dataclass(frozen=True, slots=True)
class Metric:
    """One file of metrics. name: its stem. stage: the stage that makes it.

    table: the table that shows it, None where none does. static: it follows from predictions alone, so `static_tables` shows it.
    compared: the comparison with the paper reads it. drawn: figures show it. need: it is made only where an arm has this need.
    """

    name: str
    stage: str = "metrics"
    table: str | None = None
    static: bool = False
    compared: bool = False
    drawn: bool = False
    need: Need | None = None

    @property
    def file(self) -> str:
        """The name of the file."""
        return f"{self.name}.csv"


ACROSS = "controls"
"""The stage that makes the metrics across splits."""
METRICS: tuple[Metric, ...] = (
    Metric("static_outcomes"),
    Metric("embodied_outcomes"),
    Metric("static_rates", table="static", static=True, compared=True, drawn=True),
    Metric("embodied_rates", table="embodied", compared=True),
    Metric("rejections", stage="episodes", table="rejections"),
    Metric("taxonomy", table="taxonomy", static=True, compared=True),
    Metric("significance", table="significance", compared=True),
    Metric("navigation", table="navigation", compared=True),
    Metric("difficulty", table="difficulty", static=True, compared=True, drawn=True),
    Metric("budget", table="budget", static=True, compared=True, drawn=True),
    Metric("readings", table="readings", static=True, compared=True),
    Metric("pairings", table="pairings", static=True, compared=True),
    Metric("shortcuts", table="shortcuts", static=True),
    Metric("rescued", table="rescued", compared=True),
    Metric("own_task", table="own_task", compared=True),
    Metric("seeds", table="seeds", compared=True),
    Metric("scenes", table="scenes"),
    Metric("mover", table="mover", compared=True),
    Metric("controls", stage=ACROSS, table="controls", compared=True, drawn=True),
    Metric("overview", stage=ACROSS, table="overview"),
    Metric("split_significance", stage=ACROSS, table="split_significance", compared=True),
    Metric("coverage", stage=ACROSS, table="coverage", drawn=True),
    Metric("language", stage="language", table="language", compared=True),
    Metric("perception", stage="perception", table="perception", compared=True),
    Metric("backprojection", stage="backprojection", table="backprojection", compared=True),
    Metric("sensitivity", stage="sensitivity", table="sensitivity", compared=True, drawn=True),
    Metric("gate_sweep", stage="probes", table="gate_sweep", compared=True, drawn=True),
    Metric("read_as", stage="probes", table="read_as", compared=True),
    Metric("fragments", stage="fragments", table="fragments", compared=True),
    Metric("appearance", stage="appearance", table="appearance", compared=True),
    Metric("dualmap", stage="dualmap_objects", table="dualmap", compared=True, need=Need.DUALMAP),
)


def of_split(split: str, embodied: bool = True) -> tuple[Metric, ...]:
    """The metrics of a split beside the benchmark's own. embodied: whether embodied arms run its episodes."""
    driven = (
        Metric(f"{split}_embodied_outcomes", stage="split_metrics"),
        Metric(f"{split}_embodied_rates", stage="split_metrics", table=f"{split}_embodied"),
    )
    return (
        Metric(f"{split}_outcomes", stage="split_metrics"),
        Metric(f"{split}_rates", stage="split_metrics", table=split),
        *(driven if embodied else ()),
        Metric(f"{split}_rejections", stage="episodes", table=f"{split}_rejections"),
    )


def of_stage(stage: str) -> tuple[str, ...]:
    """The names of the metrics that a stage makes."""
    return tuple(metric.name for metric in METRICS if metric.stage == stage)


def in_tables(arms: Iterable[Arm], splits: Iterable[Split] = ()) -> tuple[str, ...]:
    """Name the metrics that results/tables shows of these arms and splits, but for those across splits."""
    arms = tuple(arms)
    of_main = (metric.name for metric in _made_for(arms) if metric.table is not None and metric.stage != ACROSS)
    return (*of_main, *_of_splits(arms, splits))


def in_all_tables(arms: Iterable[Arm], splits: Iterable[Split] = ()) -> tuple[str, ...]:
    """Name the metrics that results/all adds to results/tables: those across all splits, and those of further splits."""
    return (*of_stage(ACROSS), *_of_splits(tuple(arms), splits))


def _of_splits(arms: Sequence[Arm], splits: Iterable[Split]) -> Iterator[str]:
    return (name for split in splits for name in in_split_tables(arms, split))


def in_split_tables(arms: Iterable[Arm], split: Split) -> tuple[str, ...]:
    """The names of the metrics that the tables of one split show, of those that are made for these arms."""
    embodied = any(arm.kind is Kind.EMBODIED and arm.name in split.arms for arm in arms)
    return tuple(metric.name for metric in of_split(split.name, embodied) if metric.table is not None)


def in_static_tables() -> tuple[str, ...]:
    """The names of the metrics that the tables of the static arms alone show."""
    return tuple(metric.name for metric in METRICS if metric.static)


def compared(arms: Iterable[Arm]) -> tuple[str, ...]:
    """The names of the metrics that the comparison with the paper reads, of those that are made for these arms."""
    return tuple(metric.name for metric in _made_for(arms) if metric.compared)


def drawn(arms: Iterable[Arm]) -> tuple[str, ...]:
    """The names of the metrics that figures show, of those that are made for these arms."""
    return tuple(metric.name for metric in _made_for(arms) if metric.drawn)


def table_of(metric: str, splits: Iterable[str] = ()) -> str:
    """The name of the table that shows a metric. Raises ValueError for one that no table shows.

    splits: the names of those beside the benchmark's own.
    """
    of_splits = (one for split in splits for one in of_split(split))
    shown = {one.name: one.table for one in (*METRICS, *of_splits) if one.table is not None}
    if metric not in shown:
        raise ValueError(f"no table shows {metric}; those that are shown are {', '.join(shown)}")
    return shown[metric]


def _made_for(arms: Iterable[Arm]) -> list[Metric]:
    needs = {need for arm in arms for need in arm.needs}
    return [metric for metric in METRICS if metric.need is None or metric.need in needs]
