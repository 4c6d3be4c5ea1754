"""README.md: the card of the data set, with the front matter by which Hugging Face finds its configurations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ovman.agents.interface import VISITS
from ovman.dataset.about import About
from ovman.dataset.columns import Table
from ovman.dataset.episodes import tour_id
from ovman.dataset.files import DataFile
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.report.tables.table import pipe_table

CARD = "README.md"
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
LOAD_TOURS = """
The tours take {size}. The benchmark's Git repository leaves them out; in its checkout, `ovman dataset --out dataset` records them
after `pip install '.[dataset]'`.

```python
tours = load_dataset(here, "tours", split="{split}")  # with streaming=True one row after the other
episode = episodes[0]
first = tours.filter(lambda name: name == episode["first_tour"], input_columns="tour").sort("view")
first[0]["rgb"], first[0]["depth"]  # pictures of Pillow; depth / 1000 is metres
```
"""
ABSENT = """
The tours are not among them: `ovman dataset` without `--without-tours` makes them.
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
    said: Mapping[str, Any],
) -> str:
    """Return the card. said: as `ovman.dataset.about.responsible`."""
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
        load_tours=LOAD_TOURS.format(split=small, size=_size(_of(toured[0], files))) if toured else "",
        configurations="\n\n".join(_configuration(table) for table in tables),
        absent="" if toured else ABSENT,
        files=_files(tables, files),
        responsible="\n\n".join(_paragraphs(said["rai"])),
        licence=about.licence,
        sources=", ".join(f"<{source['url']}>" for source in said["derived_from"]),
        bibtex=about.bibtex,
    )
    return f"---\n{matter}---\n\n{text}"


def _of(table: Table, files: Sequence[DataFile], split: str | None = None) -> list[DataFile]:
    return [file for file in files if file.table == table.name and split in (None, file.split)]


def _splits(table: Table, files: Sequence[DataFile]) -> list[str]:
    return list(dict.fromkeys(file.split for file in _of(table, files)))


def _size(files: Sequence[DataFile]) -> str:
    return f"{sum(file.size for file in files) / 1e6:.1f} MB"


def _counts(tables: Sequence[Table], files: Sequence[DataFile]) -> Iterator[str]:
    for table in tables:
        of = _of(table, files)
        yield f"`{table.name}` has {sum(file.rows for file in of)} rows in {_size(of)}."


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


def _files(tables: Sequence[Table], files: Sequence[DataFile]) -> str:
    cells = []
    for table in tables:
        for split in _splits(table, files):
            of = _of(table, files, split)
            name = f"`{table.file(split, '*') if len(of) > 1 else of[0].name}`"
            cells.append([name, str(len(of)), str(sum(file.rows for file in of)), str(sum(file.size for file in of))])
    return _table(["files", "number", "rows", "bytes"], cells)


def _paragraphs(said: Mapping[str, Any]) -> Iterator[str]:
    for name, title in TITLES.items():
        texts = said[name] if isinstance(said[name], list) else [said[name]]
        yield f"**{title}.** " + "\n\n".join(" ".join(text.split()) for text in texts)


def _table(header: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    return pipe_table(header, cells, [name in ("number", "rows", "bytes") for name in header]).rstrip()
