"""The stage "tables": every table of the results, each as .csv, .md and .tex."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ovman.models.note import sentence
from ovman.models.settings import Arm, Settings, arms_of
from ovman.report.budget import budget_table
from ovman.report.cells import Record
from ovman.report.constants import constants_table
from ovman.report.difficulty import difficulty_table
from ovman.report.dualmap import dualmap_table
from ovman.report.language import language_table
from ovman.report.latex import escaped, latex, tex
from ovman.report.markdown import markdown
from ovman.report.navigation import navigation_table
from ovman.report.own_task import own_task_table
from ovman.report.pairings import pairings_table
from ovman.report.perception import backprojection_table, perception_table
from ovman.report.rates import embodied_table, static_table
from ovman.report.rejections import rejections_table
from ovman.report.scenes import scenes_table
from ovman.report.significance import significance_table
from ovman.report.spread import seeds_table
from ovman.report.table import Table, Text, csv_text
from ovman.report.taxonomy import taxonomy_table

# From the stem of a file of metrics to the table that it is shown as; the second argument is the stage's constants.
TABLES: Mapping[str, Callable[[Sequence[Record], Any], Table]] = {
    "static_rates": lambda rows, constants: static_table(
        rows, constants.success.radius_m, constants.evaluation.confidence, arms_of(constants.arms)
    ),
    "embodied_rates": lambda rows, constants: embodied_table(rows, constants.evaluation.confidence, arms_of(constants.arms)),
    "rejections": lambda rows, constants: rejections_table(rows),
    "taxonomy": lambda rows, constants: taxonomy_table(rows, constants.success.radius_m, constants.evaluation.near_miss_m),
    "significance": lambda rows, constants: significance_table(rows),
    "navigation": lambda rows, constants: navigation_table(rows, arms_of(constants.arms)),
    "difficulty": lambda rows, constants: difficulty_table(rows, constants.evaluation.confidence, arms_of(constants.arms)),
    "budget": lambda rows, constants: budget_table(rows, constants.evaluation.confidence),
    "pairings": lambda rows, constants: pairings_table(rows),
    "own_task": lambda rows, constants: own_task_table(
        rows, constants.success.radius_m, constants.evaluation.confidence, arms_of(constants.arms)
    ),
    "seeds": lambda rows, constants: seeds_table(rows, arms_of(constants.arms)),
    "scenes": lambda rows, constants: scenes_table(rows, arms_of(constants.arms)),
    "dualmap": lambda rows, constants: dualmap_table(rows),
    "language": lambda rows, constants: language_table(rows, constants.evaluation.confidence),
    "perception": lambda rows, constants: perception_table(
        rows, constants.perception.detector.confidence, constants.perception.detector.min_mask_px
    ),
    "backprojection": lambda rows, constants: backprojection_table(rows, constants.perception.detector.min_mask_px),
}


def run(metrics: Sequence[Path], constants: Settings, output_dir: Path, notes: Sequence[Path] = ()) -> None:
    """Writes the table of each file of metrics, and that of the constants, into output_dir, made if need be. Byte-stable.

    notes: records of whether plug-ins made their arms' records, each called after its plug-in; the tables of these arms say which
    did not.
    metrics: files whose stems are in ``TABLES``. constants: all of ``ovman.report.constants.KEYS`` and evaluation.confidence.
    Raises ValueError in one line for a file that no table shows or whose rows contradict themselves, naming the file.
    """
    shown = [noted(table(path, constants), notes, arms_of(constants.arms)) for path in metrics]
    write([constants_table(constants), *shown], output_dir)


def noted(table: Table, notes: Sequence[Path], all_arms: Sequence[Arm]) -> Table:
    """A table of all arms of a kind with a sentence for each plug-in with such arms that did not make their records."""
    mine = {arm.made_by for arm in all_arms if table.name == arm.kind}
    sentences = [said for path in notes if path.stem in mine and (said := sentence(path)) is not None]
    if not sentences:
        return table
    plain = table.caption.plain if isinstance(table.caption, Text) else table.caption
    source = " ".join([tex(table.caption), *map(escaped, sentences)])
    return replace(table, caption=Text(" ".join([plain, *sentences]), source))


def write(tables: Iterable[Table], output_dir: Path) -> None:
    """Each table as .csv, .md and .tex under its name."""
    output_dir.mkdir(parents=True, exist_ok=True)
    for table in tables:
        for suffix, render in ((".csv", csv_text), (".md", markdown), (".tex", latex)):
            (output_dir / f"{table.name}{suffix}").write_text(render(table), encoding="utf-8", newline="\n")


def table(path: Path, constants: Settings) -> Table:
    """The table of a file of metrics. Raises as ``run`` does."""
    if path.stem not in TABLES:
        raise ValueError(f"{path}: no table shows it; those that are shown are {', '.join(TABLES)}")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        return TABLES[path.stem](rows, constants)
    except (ValueError, KeyError) as error:
        raise ValueError(f"{path}: {error.args[0]}") from None
