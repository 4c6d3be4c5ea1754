"""The metadata of the data set: README.md (the card) and croissant.json.

Croissant 1.1 has the vocabulary for responsible AI, which the NeurIPS track asks for. Names of files are relative to the folder,
so that a copy is read where it lies.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ovman.agents.interface import VISITS
from ovman.analysis.outcomes import ALL
from ovman.analysis.rates import Rate
from ovman.analysis.rows import read_rows
from ovman.dataset.tables import TABLES, Column, Table, tour_id
from ovman.entry.release import Release
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.report.results_page import tabulate_choices
from ovman.report.tables.table import EMPTY, pipe_table
from ovman.shipped import HOME

HERE = Path(__file__).parent
LICENCE = "https://spdx.org/licenses/Apache-2.0.html"
PARQUET = "application/x-parquet"
SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (1_000_000, "100K<n<1M"))
"""Hugging Face's classes of sizes by the number of rows that they end below."""
KINDS = {
    "text": ("sc:Text", "text"),
    "json": ("sc:Text", "JSON"),
    "integer": ("sc:Integer", "integer"),
    "number": ("sc:Float", "number"),
    "flag": ("sc:Boolean", "true or false"),
    "image": ("sc:ImageObject", "PNG"),
}
"""Names of each kind of column in Croissant and in the card."""
TITLES = {
    "dataUseCases": "Uses",
    "dataLimitations": "Limits",
    "dataBiases": "Biases",
    "personalSensitiveInformation": "Personal information",
    "dataSocialImpact": "Social impact",
    "dataReleaseMaintenancePlan": "Maintenance",
}
SIZED = ("two_visits", "joint")
"""Static arms whose design effect the card has."""
FILES = ("name", "table", "split", "rows", "size", "sha256")
"""Columns of the list of Parquet files. name: relative to the folder of the data set; size: bytes."""


def read_facts() -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the contents of CITATION.cff and of responsible.yaml."""
    files = HOME / "CITATION.cff", HERE / "responsible.yaml"
    cited, described = (yaml.safe_load(file.read_text(encoding="utf-8")) for file in files)
    return cited, described


def render_card(release: Release, splits: Mapping[str, Sequence[Episode]], files: pd.DataFrame) -> str:
    """Return the card, with the front matter in which Hugging Face finds licence, tags and configurations.

    files: One row of FILES per Parquet file.
    """
    name = release.directory.resolve().name
    development = [split for split, settings in release.settings.splits.items() if not settings.in_main_job]
    cited, described = read_facts()
    rows = files.rows.sum()
    loader = FileSystemLoader(HERE)
    environment = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True)  # noqa: S701
    return environment.get_template("card.md.j2").render(
        name=name,
        cited=cited,
        described=described,
        titles=TITLES,
        size_category=next((name for end, name in SIZES if rows < end), "1M<n<10M"),
        tables=_tables_of(files),
        files=files,
        has_tours="tours" in set(files.table),
        smallest=min(splits, key=lambda split: len(splits[split])),
        megabytes=lambda table: f"{files[files.table == table]['size'].sum() / 1e6:.1f}",
        split_table=_split_table(splits, development),
        effective_table=tabulate_sizes(splits, release.directory),
        choices=tabulate_choices(release.settings).rstrip(),
        column_table=_column_table,
        file_table=_file_table(files),
        bibtex=_bibtex(cited),
    )


def croissant(name: str, files: pd.DataFrame) -> dict[str, Any]:
    """Return the metadata in Croissant. files: as for `render_card`."""
    cited, described = read_facts()
    tables = _tables_of(files)
    published = {"datePublished": str(cited["date-released"])} if "date-released" in cited else {}
    return {
        "@context": json.loads((HERE / "croissant_context.json").read_text(encoding="utf-8")),
        "@type": "sc:Dataset",
        "conformsTo": ["http://mlcommons.org/croissant/1.1", "http://mlcommons.org/croissant/RAI/1.0"],
        "name": name,
        "alternateName": cited["title"],
        "description": described["description"],
        "version": str(cited["version"]),
        "license": LICENCE,
        "creator": [{"@type": "sc:Organization", "name": _name(author)} for author in cited["authors"]],
        "keywords": cited["keywords"],
        "inLanguage": "en",
        "citeAs": _bibtex(cited),
        **published,
        "isLiveDataset": False,
        **{f"rai:{name}": text for name, text in described["rai"].items()},
        "prov:wasDerivedFrom": [
            {"@id": one["url"], "@type": "prov:Entity", "prov:label": one["name"]} for one in described["derived_from"]
        ],
        "prov:wasGeneratedBy": [
            {"@type": "prov:Activity", "prov:label": one["name"], "sc:description": one["about"]}
            for one in described["generated_by"]
        ],
        "distribution": [*map(_file_object, files.itertuples()), *map(_file_set, tables)],
        "recordSet": [
            {
                "@type": "cr:RecordSet",
                "@id": table.name,
                "name": table.name,
                "description": table.about,
                "field": [_field(table, column) for column in table.columns],
            }
            for table in tables
        ],
    }


def _file_object(file: Any) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "description": f"{file.table} of the split {file.split}",
        "contentUrl": file.name,
        "contentSize": f"{file.size} B",
        "encodingFormat": PARQUET,
        "sha256": file.sha256,
    }


def _file_set(table: Table) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{table.name}-files",
        "name": f"{table.name}-files",
        "description": f"all files of the table {table.name}",
        "encodingFormat": PARQUET,
        "includes": table.file("*", "*"),
    }


def _field(table: Table, column: Column) -> dict[str, Any]:
    # A picture is a struct of its bytes and an unused path.
    transform = {"transform": {"jsonPath": "bytes"}} if column.kind == "image" else {}
    return {
        "@type": "cr:Field",
        "@id": f"{table.name}/{column.name}",
        "name": column.name,
        "description": f"{'truth, for the evaluator alone: ' if column.is_truth else ''}{column.about}",
        "dataType": KINDS[column.kind][0],
        "source": {"fileSet": {"@id": f"{table.name}-files"}, "extract": {"column": column.name}, **transform},
    }


def _tables_of(files: pd.DataFrame) -> list[Table]:
    return [table for table in TABLES.values() if table.name in set(files.table)]


def _split_table(splits: Mapping[str, Sequence[Episode]], development: Sequence[str]) -> str:
    rows = []
    for name, episodes in splits.items():
        scenes = {episode.scene for episode in episodes}
        tours = {tour_id(episode, which) for episode in episodes for which in VISITS}
        of = Counter(episode.relation for episode in episodes)
        counts = [len(scenes), len(tours), *(of[relation] for relation in Relation), len(episodes)]
        rows.append([f"`{name}`", "development" if name in development else "test", *map(str, counts)])
    header = ["split", "for", "floor plans", "tours", *(relation.value for relation in Relation), "all"]
    return pipe_table(header, rows, [number > 1 for number in range(len(header))]).rstrip()


def tabulate_sizes(splits: Mapping[str, Sequence[Episode]], release: Path) -> str:
    """Return the table of effective sizes; the design effects are those of the release's metrics."""
    rows = []
    for split, episodes in splits.items():
        referents = [(one.scene, one.target) for one in episodes]
        moving = [(one.scene, one.target) for one in episodes if one.relation is Relation.MOVING]
        row = [f"`{split}`", str(len(episodes)), _write_effective([one.scene for one in episodes])]
        row += [_write_effective(referents), _write_effective(moving)]
        file = release / "metrics" / split / "static_rates.csv"
        rates = {rate.arm: rate for rate in read_rows(file, Rate) if rate.relation == ALL} if file.is_file() else {}
        for arm in SIZED:
            effect = rates[arm].design_effect if arm in rates else None
            row.append(EMPTY if effect is None else f"{len(episodes) / max(1.0, effect):.0f}")
        rows.append(row)
    header = ["split", "episodes", "floor plans or homes", "referents", "of MOVING", *(f"effective, {arm}" for arm in SIZED)]
    return pipe_table(header, rows, [number > 0 for number in range(len(header))]).rstrip()


def _write_effective(members: Sequence[Hashable]) -> str:
    """Write how many different members there are, and how many of equal size would be worth as much."""
    counts = Counter(members).values()
    return f"{len(counts)} ({len(members) ** 2 / sum(n * n for n in counts):.0f})" if members else EMPTY


def _column_table(table: Table) -> str:
    cells = [[f"`{c.name}`", KINDS[c.kind][1], c.about, "truth" if c.is_truth else ""] for c in table.columns]
    return pipe_table(["column", "form", "content", ""], cells, [False] * 4).rstrip()


def _file_table(files: pd.DataFrame) -> str:
    cells = []
    for _, of in files.groupby(["table", "split"], sort=False):
        first = of.iloc[0]
        name = TABLES[first.table].file(first.split, "*") if len(of) > 1 else first["name"]
        cells.append([f"`{name}`", str(len(of)), str(of.rows.sum()), str(of["size"].sum())])
    return pipe_table(["files", "number", "rows", "bytes"], cells, [False, True, True, True]).rstrip()


def _bibtex(cited: Mapping[str, Any]) -> str:
    """Return the paper to cite."""
    paper = cited["preferred-citation"]
    authors = " and ".join(map(_name, paper["authors"]))
    return f"@article{{ovman, title = {{{paper['title']}}}, author = {{{authors}}}}}"


def _name(author: Mapping[str, str]) -> str:
    return author["name"] if "name" in author else f"{author['family-names']}, {author['given-names']}"
