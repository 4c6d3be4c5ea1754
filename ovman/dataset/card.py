"""README.md: the card of the data set, with the front matter by which Hugging Face finds its configurations."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ovman.dataset.about import About
from ovman.dataset.columns import Table
from ovman.dataset.episodes import tour_id
from ovman.dataset.files import DataFile
from ovman.entry.tour_cache import VISITS
from ovman.models.episode import Episode
from ovman.models.relation import Relation
from ovman.report.tables.table import pipe_table

CARD = "README.md"
ROW = re.compile(r"^\| *`([^`]+)` *\|.*\| *`([0-9a-f]{64})` *\|$")
"""A line of the card's table of files: name first, SHA-256 last."""
SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (1_000_000, "100K<n<1M"))
"""Hugging Face's classes of sizes by the number of rows that they end below."""
TITLES = {
    "dataUseCases": "Uses",
    "dataLimitations": "Limits",
    "dataBiases": "Biases",
    "personalSensitiveInformation": "Personal information",
    "dataSocialImpact": "Social impact",
    "dataReleaseMaintenancePlan": "Maintenance",
}
LOAD_TOURS = """tours = load_dataset(".", "tours", split="{split}")  # with streaming=True one row after the other
episode = episodes[0]
first = tours.filter(lambda name: name == episode["first_tour"], input_columns="tour").sort("view")
first[0]["rgb"], first[0]["depth"]  # pictures of Pillow; depth / 1000 is metres
"""


def front_matter(about: About, tables: Sequence[Table], files: Sequence[DataFile]) -> dict[str, Any]:
    """What Hugging Face reads of a card: licence, tags, and each configuration with the files of its splits."""
    rows = sum(file.rows for file in files)
    return {
        "license": about.licence.lower(),
        "pretty_name": about.name,
        "language": ["en"],
        "task_categories": ["robotics"],
        "size_categories": [next((name for end, name in SIZES if rows < end), "1M<n<10M")],
        "tags": [keyword.lower().replace(" ", "-") for keyword in about.keywords],
        "configs": [
            {
                "config_name": table.name,
                **({"default": True} if number == 0 else {}),
                "data_files": [{"split": split, "path": table.file(split, "*")} for split in _splits(table, files)],
            }
            for number, table in enumerate(tables)
        ],
    }


@dataclass(frozen=True, slots=True)
class SplitOf:
    """A split. development: whether agents may be chosen and fitted on it."""

    name: str
    episodes: Sequence[Episode]
    development: bool


def card(
    about: About,
    splits: Sequence[SplitOf],
    tables: Sequence[Table],
    files: Sequence[DataFile],
    beside: Mapping[str, str],
    said: Mapping[str, Any],
) -> str:
    """The card. beside: SHA-256 of the other files of the folder by their names; said: as `ovman.dataset.about.responsible`."""
    matter = yaml.safe_dump(front_matter(about, tables, files), sort_keys=False, allow_unicode=True, width=1000)
    toured = [table for table in tables if table.pictured]
    small = min(splits, key=lambda split: len(split.episodes)).name
    body = (Path(__file__).parent / "card.md").read_text(encoding="utf-8")
    text = body.format(
        name=about.name,
        description=about.description,
        version=about.version,
        counts=" ".join(_counts(tables, files)),
        splits=_split_table(splits),
        split=small,
        load_tours=LOAD_TOURS.format(split=small) if toured else "",
        configurations="\n\n".join(_configuration(table) for table in tables),
        absent="" if toured else " The tours are not among them: `ovman dataset` without `--without-tours` makes them.",
        files=_files(files, beside),
        responsible="\n\n".join(_paragraphs(said["rai"])),
        licence=about.licence,
        sources=", ".join(f"<{source['url']}>" for source in said["derived_from"]),
        bibtex=about.bibtex,
    )
    return f"---\n{matter}---\n\n{text}"


def checksums(text: str) -> dict[str, str]:
    """The SHA-256 of each file that a card names."""
    found = (ROW.match(line) for line in text.splitlines())
    return {match[1]: match[2] for match in found if match}


def _splits(table: Table, files: Sequence[DataFile]) -> list[str]:
    return list(dict.fromkeys(file.split for file in files if file.table == table.name))


def _counts(tables: Sequence[Table], files: Sequence[DataFile]) -> Iterator[str]:
    for table in tables:
        of = [file for file in files if file.table == table.name]
        yield f"`{table.name}` has {sum(file.rows for file in of)} rows in {sum(file.size for file in of) / 1e6:.1f} MB."


def _split_table(splits: Sequence[SplitOf]) -> str:
    rows = []
    for split in splits:
        scenes, tours = (
            {episode.scene for episode in split.episodes},
            {tour_id(episode, which) for episode in split.episodes for which in VISITS},
        )
        of = Counter(episode.relation for episode in split.episodes)
        use = "development" if split.development else "test"
        counts = [len(scenes), len(tours), *(of[relation] for relation in Relation), len(split.episodes)]
        rows.append([f"`{split.name}`", use, *map(str, counts)])
    header = ["split", "for", "floor plans", "tours", *(relation.value for relation in Relation), "all"]
    return pipe_table(header, rows, [number > 1 for number in range(len(header))]).rstrip()


def _configuration(table: Table) -> str:
    cells = [
        [f"`{column.name}`", column.kind.value.said, column.about, "truth" if column.truth else ""] for column in table.columns
    ]
    return f"### {table.name}\n\n{table.about}\n\n{_table(['column', 'form', 'content', ''], cells)}"


def _files(files: Sequence[DataFile], beside: Mapping[str, str]) -> str:
    cells = [[f"`{file.name}`", str(file.rows), str(file.size), f"`{file.sha256}`"] for file in files]
    cells += [[f"`{name}`", "", "", f"`{digest}`"] for name, digest in sorted(beside.items())]
    return _table(["file", "rows", "bytes", "sha256"], cells)


def _paragraphs(said: Mapping[str, Any]) -> Iterator[str]:
    for name, title in TITLES.items():
        texts = said[name] if isinstance(said[name], list) else [said[name]]
        yield f"**{title}.** " + "\n\n".join(" ".join(text.split()) for text in texts)


def _table(header: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    return pipe_table(header, cells, [name in ("rows", "bytes") for name in header]).rstrip()
