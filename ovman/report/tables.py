"""The stage "tables": every table of the results, each as .csv, .md and .tex."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from ovman.report.constants import constants_table
from ovman.report.latex import latex
from ovman.report.markdown import markdown
from ovman.report.rates import embodied_table, static_table
from ovman.report.rejections import rejections_table
from ovman.report.table import Table, csv_text


def run(static_rates: Path, embodied_rates: Path, rejections: Path, constants: Any, output_dir: Path) -> None:
    """Writes constants, static, embodied and rejections into output_dir, which is made if need be. Byte-stable.

    static_rates, embodied_rates: what the stage "metrics" wrote; rejections: the audit of the stage "episodes".
    constants: all of ``ovman.report.constants.KEYS`` and evaluation.confidence.
    Raises ValueError in one line for a file whose rows contradict themselves, naming the file.
    """
    confidence = constants.evaluation.confidence
    tables = [
        constants_table(constants),
        _named(static_rates, lambda rows: static_table(rows, constants.success.radius_m, confidence)),
        _named(embodied_rates, lambda rows: embodied_table(rows, confidence)),
        _named(rejections, rejections_table),
    ]
    output_dir.mkdir(parents=True, exist_ok=True)
    for table in tables:
        for suffix, render in ((".csv", csv_text), (".md", markdown), (".tex", latex)):
            (output_dir / f"{table.name}{suffix}").write_text(render(table), encoding="utf-8", newline="\n")


def _named(path: Path, table_of: Any) -> Table:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        return table_of(rows)
    except (ValueError, KeyError) as error:
        raise ValueError(f"{path}: {error.args[0]}") from None
