"""The files of results/metrics: which follow from a split, which across splits, and who reads them.

Names are those of files below results/metrics without ".csv": "main/static_rates", "paper/controls", "language". The Snakefile
imports this module, so it imports nothing heavy.
"""

from __future__ import annotations

from collections.abc import Iterable

from ovman.settings import MAIN, Kind, Need, Settings
from ovman.settings.arms import Track

SPLIT_METRICS = (
    *("static_outcomes", "embodied_outcomes", "static_rates", "embodied_rates", "taxonomy", "significance", "navigation"),
    *("difficulty", "budget", "readings", "pairings", "shortcuts", "rescued", "own_task", "seeds", "scenes", "mover", "bounds"),
    "words",
)
"""The files that `ovman.analysis.metrics.write_metrics` writes for each split."""
ACROSS_METRICS = ("controls", "overview", "split_significance", "coverage", "ranks")
"""The files that `ovman.analysis.splits.write_across_splits` writes."""
OF_PERCEPTION = (
    *(
        "language",
        "perception",
        "backprojection",
        "sensitivity",
        "tolerances",
        "gate_sweep",
        "read_as",
        "fragments",
        "appearance",
        "dualmap",
    ),
)
"""Metrics of the maps of `main`, and of what is detected in its tours."""
SHOWN_OF_SPLIT = ("static_rates", "embodied_rates", "rejections", "bounds", "words")
"""Metrics of which a split has a table; splits that are like the paper's have none of bounds, and `main` has more tables."""
DRAWN = ("main/static_rates", "main/difficulty", "main/budget", "controls", "coverage", "overview", "sensitivity", "gate_sweep")
"""Metrics that figures show."""


def paper_tables(settings: Settings) -> list[str]:
    """Name the metrics that results/tables shows: of `main`, of the paper's other splits, and across these.

    Ranks compare splits of which one is not the paper's, so results/all has them.
    """
    skipped = {"static_outcomes", "embodied_outcomes", "bounds", "words"}
    of_main = [f"{MAIN}/{name}" for name in (*SPLIT_METRICS, "rejections") if name not in skipped]
    further = [name for split in _job_splits(settings, plain=True) for name in split_tables(settings, split)]
    return [*of_main, *further, *(f"paper/{name}" for name in ACROSS_METRICS if name != "ranks"), *_of_perception(settings)]


def all_tables(settings: Settings) -> list[str]:
    """Name the metrics that results/all adds: across all splits of the main job, and of the splits that are not the paper's."""
    further = [name for split in _job_splits(settings, plain=False) for name in split_tables(settings, split)]
    return [*ACROSS_METRICS, *further]


def split_tables(settings: Settings, split: str) -> list[str]:
    """Name the metrics that the tables of a split show: those of arms of some sort only if such an arm answers it."""
    plain = settings.splits[split].plain
    arms = [settings.arms[name] for name in settings.splits[split].arms if name in settings.arms]
    skipped = {"bounds" if plain else "", "" if any(arm.kind is Kind.EMBODIED for arm in arms) else "embodied_rates"}
    skipped |= {"" if any(arm.track is Track.WORDS for arm in arms) else "words"}
    return [f"{split}/{name}" for name in SHOWN_OF_SPLIT if name not in skipped]


def compared(settings: Settings) -> list[str]:
    """Name the metrics that the comparison with the paper reads."""
    of_main = [f"{MAIN}/{name}" for name in SPLIT_METRICS if name not in ("shortcuts", "scenes", "bounds", "words")]
    further = [f"{name}/{kind}_outcomes" for plain in (True, False) for name in _job_splits(settings, plain) for kind in Kind]
    return [*of_main, *further, *ACROSS_METRICS, *_of_perception(settings)]


def _of_perception(settings: Settings) -> Iterable[str]:
    has_dualmap = any(Need.DUALMAP in arm.needs for arm in settings.arms.values())
    return (name for name in OF_PERCEPTION if has_dualmap or name != "dualmap")


def _job_splits(settings: Settings, plain: bool) -> list[str]:
    splits = settings.splits.items()
    return [name for name, split in splits if split.in_main_job and name != MAIN and split.plain is plain]
