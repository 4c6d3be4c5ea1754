"""The metadata of the data set: README.md (the card), croissant.json and .zenodo.json.

Croissant 1.1 has the vocabulary for responsible AI, which the NeurIPS track asks for. Names of files are relative to the folder,
so that a copy is read where it lies; with the URL of a page they are below that page, as Hugging Face has them.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from html import escape
from pathlib import Path
from typing import Any

import yaml

from ovman.agents.interface import VISITS
from ovman.dataset.tables import TABLES, Column, Table, tour_id
from ovman.entry import EntryError
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.report.tables.table import pipe_table
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


@dataclass(frozen=True, slots=True)
class DataFile:
    """A Parquet file. name: relative to the folder of the data set; size: bytes."""

    name: str
    table: str
    split: str
    rows: int
    size: int
    sha256: str


@dataclass(frozen=True, slots=True)
class SplitOf:
    """A split of the data set. is_development: whether agents may be chosen and fitted on it."""

    name: str
    episodes: Sequence[Episode]
    is_development: bool


@dataclass(frozen=True, slots=True)
class About:
    """Facts about the data set as a whole.

    cited: the content of CITATION.cff; described: the content of responsible.yaml; url: the page that it is published at; day: of
    its publication, both None if unknown.
    """

    name: str
    cited: Mapping[str, Any]
    described: Mapping[str, Any]
    url: str | None
    day: str | None

    @staticmethod
    def read(name: str, url: str | None = None, day: str | None = None) -> About:
        """Read what is said of the release of that name. Raises EntryError for a day that is not a date."""
        if day is not None:
            try:
                date.fromisoformat(day)
            except ValueError:
                raise EntryError(f"--date: {day!r} is not a day; write YYYY-MM-DD") from None
        cited = yaml.safe_load((HOME / "CITATION.cff").read_text(encoding="utf-8"))
        described = yaml.safe_load((HERE / "responsible.yaml").read_text(encoding="utf-8"))
        return About(name, cited, described, url, day or cited.get("date-released"))

    @property
    def description(self) -> str:
        """The description in one line."""
        return str(_join_lines(self.described["description"]))

    @property
    def authors(self) -> list[str]:
        """The authors of the data set."""
        return [_name(author) for author in self.cited["authors"]]

    @property
    def paper(self) -> tuple[str, list[str]]:
        """Title and authors of the paper to cite."""
        paper = self.cited["preferred-citation"]
        return paper["title"], [_name(author) for author in paper["authors"]]

    @property
    def bibtex(self) -> str:
        """The paper to cite, as BibTeX."""
        title, authors = self.paper
        return f"@article{{ovman, title = {{{title}}}, author = {{{' and '.join(authors)}}}}}"


def render_card(about: About, splits: Sequence[SplitOf], files: Sequence[DataFile]) -> str:
    """Return the card, with the front matter in which Hugging Face finds licence, tags and configurations."""
    tables, rows = _tables_of(files), sum(file.rows for file in files)
    matter = {
        "license": about.cited["license"].lower(),
        "pretty_name": about.name,
        "language": ["en"],
        "task_categories": ["robotics"],
        "size_categories": [next((name for end, name in SIZES if rows < end), "1M<n<10M")],
        "tags": [keyword.lower().replace(" ", "-") for keyword in about.cited["keywords"]],
        "configs": [
            {
                "config_name": table.name,
                **({"default": True} if number == 0 else {}),
                "data_files": [{"split": split, "path": table.file(split, "*")} for split in _splits_of(table, files)],
            }
            for number, table in enumerate(tables)
        ],
    }
    of = {table.name: [file for file in files if file.table == table.name] for table in tables}
    small = min(splits, key=lambda split: len(split.episodes)).name
    load_tours = (HERE / "load_tours.md").read_text(encoding="utf-8").format(size=_size(of.get("tours", ())), split=small)
    text = (HERE / "card.md").read_text(encoding="utf-8").format(
        name=about.name,
        description=about.description,
        version=about.cited["version"],
        counts=" ".join(f"`{name}` has {sum(f.rows for f in some)} rows in {_size(some)}." for name, some in of.items()),
        splits=_split_table(splits),
        split=small,
        load_tours=load_tours if "tours" in of else "",
        configurations="\n\n".join(f"### {table.name}\n\n{table.about}\n\n{_column_table(table)}" for table in tables),
        absent="" if "tours" in of else "\nThe tours are not among them: `ovman dataset` without `--without-tours` makes them.\n",
        files=_file_table(tables, files),
        responsible="\n\n".join(f"**{title}.** {_paragraphs(about.described['rai'][name])}" for name, title in TITLES.items()),
        licence=about.cited["license"],
        sources=", ".join(f"<{source['url']}>" for source in about.described["derived_from"]),
        bibtex=about.bibtex,
    )  # fmt: skip
    return f"---\n{yaml.safe_dump(matter, sort_keys=False, allow_unicode=True, width=1000)}---\n\n{text}"


def croissant(about: About, files: Sequence[DataFile]) -> dict[str, Any]:
    """Return the metadata in Croissant."""
    described, url = about.described, about.url
    return {
        "@context": json.loads((HERE / "croissant_context.json").read_text(encoding="utf-8")),
        "@type": "sc:Dataset",
        "conformsTo": ["http://mlcommons.org/croissant/1.1", "http://mlcommons.org/croissant/RAI/1.0"],
        "name": about.name,
        "alternateName": about.cited["title"],
        "description": about.description,
        "version": str(about.cited["version"]),
        "license": LICENCE,
        "creator": [{"@type": "sc:Organization", "name": author} for author in about.authors],
        "keywords": about.cited["keywords"],
        "inLanguage": "en",
        "citeAs": about.bibtex,
        **({} if url is None else {"url": url}),
        **({} if about.day is None else {"datePublished": about.day}),
        "isLiveDataset": False,
        **{f"rai:{name}": _join_lines(text) for name, text in described["rai"].items()},
        "prov:wasDerivedFrom": [
            {"@id": one["url"], "@type": "prov:Entity", "prov:label": one["name"]} for one in described["derived_from"]
        ],
        "prov:wasGeneratedBy": [
            {"@type": "prov:Activity", "prov:label": one["name"], "sc:description": one["about"]}
            for one in described["generated_by"]
        ],
        "distribution": [
            *([] if url is None else [_repository(url)]),
            *(_file_object(file, url) for file in files),
            *(_file_set(table, url) for table in _tables_of(files)),
        ],
        "recordSet": [
            {
                "@type": "cr:RecordSet",
                "@id": table.name,
                "name": table.name,
                "description": table.about,
                "field": [_field(table, column) for column in table.columns],
            }
            for table in _tables_of(files)
        ],
    }


def zenodo(about: About) -> dict[str, Any]:
    """Return the metadata of a deposit at Zenodo."""
    title, authors = about.paper
    sources = [source["url"] for source in about.described["derived_from"]]
    return {
        "title": f"{about.name}: {about.cited['title']}",
        "upload_type": "dataset",
        "description": f"<p>{escape(about.description)}</p>",
        "creators": [{"name": author} for author in about.authors],
        "license": about.cited["license"].lower(),
        "access_right": "open",
        "keywords": about.cited["keywords"],
        "language": "eng",
        "version": str(about.cited["version"]),
        "references": [f"{'; '.join(authors)}: {title}"],
        "related_identifiers": [{"identifier": url, "relation": "isDerivedFrom", "scheme": "url"} for url in sources],
        **({} if about.day is None else {"publication_date": about.day}),
    }


def _repository(url: str) -> dict[str, Any]:
    """Return the page's Git repository, which contains the sets of files."""
    return {
        "@type": "cr:FileObject",
        "@id": "repository",
        "name": "repository",
        "description": "the data set's repository",
        "contentUrl": url,
        "encodingFormat": "git+https",
        # The format defines no digest of a repository and asks for this in its place.
        "sha256": "https://github.com/mlcommons/croissant/issues/80",
    }


def _file_object(file: DataFile, url: str | None) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "description": f"{file.table} of the split {file.split}",
        "contentUrl": file.name if url is None else f"{url}/resolve/main/{file.name}",
        "contentSize": f"{file.size} B",
        "encodingFormat": PARQUET,
        "sha256": file.sha256,
    }


def _file_set(table: Table, url: str | None) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{table.name}-files",
        "name": f"{table.name}-files",
        "description": f"all files of the table {table.name}",
        **({} if url is None else {"containedIn": {"@id": "repository"}}),
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


def _tables_of(files: Sequence[DataFile]) -> list[Table]:
    return [table for table in TABLES.values() if any(file.table == table.name for file in files)]


def _splits_of(table: Table, files: Sequence[DataFile]) -> list[str]:
    return list(dict.fromkeys(file.split for file in files if file.table == table.name))


def _size(files: Sequence[DataFile]) -> str:
    return f"{sum(file.size for file in files) / 1e6:.1f} MB"


def _split_table(splits: Sequence[SplitOf]) -> str:
    rows = []
    for split in splits:
        scenes = {episode.scene for episode in split.episodes}
        tours = {tour_id(episode, which) for episode in split.episodes for which in VISITS}
        of = Counter(episode.relation for episode in split.episodes)
        counts = [len(scenes), len(tours), *(of[relation] for relation in Relation), len(split.episodes)]
        rows.append([f"`{split.name}`", "development" if split.is_development else "test", *map(str, counts)])
    header = ["split", "for", "floor plans", "tours", *(relation.value for relation in Relation), "all"]
    return pipe_table(header, rows, [number > 1 for number in range(len(header))]).rstrip()


def _column_table(table: Table) -> str:
    cells = [[f"`{c.name}`", KINDS[c.kind][1], c.about, "truth" if c.is_truth else ""] for c in table.columns]
    return pipe_table(["column", "form", "content", ""], cells, [False] * 4).rstrip()


def _file_table(tables: Sequence[Table], files: Sequence[DataFile]) -> str:
    cells = []
    for table in tables:
        for split in _splits_of(table, files):
            of = [file for file in files if (file.table, file.split) == (table.name, split)]
            name = table.file(split, "*") if len(of) > 1 else of[0].name
            cells.append([f"`{name}`", str(len(of)), str(sum(file.rows for file in of)), str(sum(file.size for file in of))])
    return pipe_table(["files", "number", "rows", "bytes"], cells, [False, True, True, True]).rstrip()


def _paragraphs(said: str | Sequence[str]) -> str:
    return "\n\n".join(map(_join_lines, [said] if isinstance(said, str) else said))


def _join_lines(text: Any) -> Any:
    if isinstance(text, list):
        return [_join_lines(one) for one in text]
    return " ".join(text.split()) if isinstance(text, str) else text


def _name(author: Mapping[str, str]) -> str:
    return author["name"] if "name" in author else f"{author['family-names']}, {author['given-names']}"
