"""The tables of the results: every table of metrics is one entry of TABLES, and is written as csv, Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ovman.records.note import sentence
from ovman.report.tables import benchmark, comparisons, perception, success
from ovman.report.tables.table import Table, TableSpec, csv_text, latex, make_table, markdown, read_metrics
from ovman.settings import MAIN, Kind, Settings, arms_of

TABLES: Mapping[str, TableSpec] = {**success.TABLES, **comparisons.TABLES, **perception.TABLES, **benchmark.TABLES}
"""By the name of the metrics that a table shows."""
_OF_SPLIT = {"static_rates": "{split}", "embodied_rates": "{split}_embodied"} | {
    name: f"{{split}}_{name}" for name in ("rejections", "bounds", "words")
}


def write_paper_tables(metric_files: Sequence[Path], settings: Settings, directory: Path, notes: Sequence[Path] = ()) -> None:
    """Write the tables of results/tables: of files of metrics, of the constants and of prior work.

    metric_files: results/metrics/[{split}/]NAME.csv. notes: whether plug-ins made the records of their arms, by the plug-in.
    """
    own = {"position": benchmark.position_table(settings), "constants": benchmark.constants_table(settings)}
    write(own | _read_tables(metric_files, settings, notes), directory)


def write_tables(metric_files: Sequence[Path], settings: Settings, directory: Path) -> None:
    """Write the table of each file of metrics into a directory."""
    write(_read_tables(metric_files, settings), directory)


def _read_tables(metric_files: Sequence[Path], settings: Settings, notes: Sequence[Path] = ()) -> dict[str, Table]:
    tables = {}
    for path in metric_files:
        spec, split = TABLES[path.stem], path.parent.name
        try:
            table = make_table(spec, read_metrics(path), settings)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{path}: {error.args[0]}") from None
        table = add_notes(table, spec.kind, notes, settings)
        if split in settings.splits and split != MAIN:
            differs = benchmark.describe_split(settings.splits[split])
            caption = f"Split {split}: {differs}. {table.caption}"
            tables[_OF_SPLIT[path.stem].format(split=split)] = replace(table, caption=caption)
        else:
            tables[path.stem.removesuffix("_rates")] = table
    return tables


def add_notes(table: Table, kind: Kind | None, notes: Sequence[Path], settings: Settings) -> Table:
    """Add a sentence to the caption for each plug-in with arms of this kind that did not make their records."""
    mine = {arm.made_by for arm in arms_of(settings.arms) if arm.kind is kind}
    said = [note for file in notes if file.stem in mine and (note := sentence(file)) is not None]
    return replace(table, caption=" ".join([table.caption, *said]))


def write(tables: Mapping[str, Table], directory: Path) -> None:
    """Write each table as .csv, .md and .tex under its name."""
    directory.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        for suffix, text in (("csv", csv_text(table)), ("md", markdown(table)), ("tex", latex(table, name))):
            (directory / f"{name}.{suffix}").write_text(text, encoding="utf-8", newline="\n")
