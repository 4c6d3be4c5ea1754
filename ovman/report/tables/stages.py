"""The stages "tables", every table of the results, and "static_tables", those of the static gate before anything drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from ovman.analysis import frames, metrics
from ovman.analysis.registry import in_static_tables, table_of
from ovman.records.note import sentence
from ovman.report.tables.constants import constants_table
from ovman.report.tables.position import POSITION, position_table
from ovman.report.tables.specs import SPECS, spec_of
from ovman.report.tables.table import Table, csv_text, latex, markdown
from ovman.settings import MAIN, Kind, Settings, arms_of


def run(
    metrics_files: Sequence[Path],
    constants: Settings,
    output_dir: Path,
    notes: Sequence[Path] = (),
    position: Path = POSITION,
) -> None:
    """Write the table of each file of metrics, that of the constants and that of prior work into output_dir, made if need be.

    Byte-stable. position: the rows on prior work.

    metrics_files: files that the registry has a table for. constants: what the stage owns. notes: records of whether plug-ins
    made their arms' records, each called after its plug-in; the tables of these arms say which did not.
    Raises ValueError in one line for a file that no table shows or whose rows contradict themselves, naming the file.
    """
    splits = [name for name in constants.splits if name != MAIN]
    made = {
        table_of(path.stem, splits): noted(table(path, constants), spec_of(path.stem, splits).kind, notes, constants)
        for path in metrics_files
    }
    write({"position": position_table(position), "constants": constants_table(constants), **made}, output_dir)


def run_split(metrics_files: Sequence[Path], constants: Settings, output_dir: Path) -> None:
    """Write the table of each file of metrics of a split into output_dir, made if need be. Else as `run`."""
    splits = [name for name in constants.splits if name != MAIN]
    write({table_of(path.stem, splits): table(path, constants) for path in metrics_files}, output_dir)


def run_static(episodes: Path, predictions: Sequence[Path], constants: Settings, output_dir: Path) -> None:
    """Write the tables of the static arms into output_dir: what the stages "metrics" and "tables" make of predictions alone.

    Nothing that needs embodied runs is in them: the taxonomy has no row of what is lost in navigation.
    """
    with TemporaryDirectory() as directory:
        metrics.run(episodes, predictions, [], constants, Path(directory))
        shown = [Path(directory, f"{name}.csv") for name in in_static_tables()]
        write({table_of(path.stem): table(path, constants) for path in shown}, output_dir)


def table(path: Path, constants: Settings) -> Table:
    """The table of a file of metrics. Raises ValueError, one line that names the file, where its rows contradict themselves."""
    spec = spec_of(path.stem, () if path.stem in SPECS else [name for name in constants.splits if name != MAIN])
    rows = frames.read(path, spec.rows)
    try:
        return spec.make(rows, constants)
    except (ValueError, KeyError) as error:
        raise ValueError(f"{path}: {error.args[0]}") from None


def noted(table: Table, kind: Kind | None, notes: Sequence[Path], constants: Settings) -> Table:
    """A table of all arms of a kind with a sentence for each plug-in with such arms that did not make their records."""
    mine = {arm.made_by for arm in arms_of(constants.arms) if arm.kind is kind}
    sentences = [said for path in notes if path.stem in mine and (said := sentence(path)) is not None]
    return replace(table, caption=" ".join([table.caption, *sentences]))


def write(tables: Mapping[str, Table], output_dir: Path) -> None:
    """Each table as .csv, .md and .tex under its name."""
    output_dir.mkdir(parents=True, exist_ok=True)
    for name, made in tables.items():
        for suffix, text in (("csv", csv_text(made)), ("md", markdown(made)), ("tex", latex(made, name))):
            (output_dir / f"{name}.{suffix}").write_text(text, encoding="utf-8", newline="\n")
