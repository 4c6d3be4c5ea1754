"""What is said of the data set as a whole; card, Croissant and Zenodo say the same."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import yaml

from ovman.entry import EntryError
from ovman.shipped import HOME

CITATION = HOME / "CITATION.cff"
RESPONSIBLE = Path(__file__).parent / "responsible.yaml"
LICENCE = "https://spdx.org/licenses/Apache-2.0.html"


@dataclass(frozen=True, slots=True)
class About:
    """name: of the release; version: of the benchmark; authors: who made it; paper: title and authors of what to cite.

    url: the page that it is published at, day: of its publication, both None where they are not known yet.
    """

    name: str
    title: str
    description: str
    version: str
    licence: str
    authors: tuple[str, ...]
    keywords: tuple[str, ...]
    paper: tuple[str, tuple[str, ...]]
    url: str | None = None
    day: str | None = None

    @property
    def bibtex(self) -> str:
        """What to cite, as BibTeX."""
        title, authors = self.paper
        return f"@article{{ovman, title = {{{title}}}, author = {{{' and '.join(authors)}}}}}"


def about(name: str, url: str | None = None, day: str | None = None, citation: Path = CITATION) -> About:
    """Of the release of that name. EntryError for a file of citation that cannot be read, or a day that is none."""
    if day is not None:
        try:
            date.fromisoformat(day)
        except ValueError:
            raise EntryError(f"--date: {day!r} is no day; write YYYY-MM-DD") from None
    try:
        cited = yaml.safe_load(citation.read_text(encoding="utf-8"))
        paper = cited["preferred-citation"]
        return About(
            name=name,
            title=cited["title"],
            description=" ".join(responsible()["description"].split()),
            version=str(cited["version"]),
            licence=cited["license"],
            authors=tuple(map(_name, cited["authors"])),
            keywords=tuple(cited["keywords"]),
            paper=(paper["title"], tuple(map(_name, paper["authors"]))),
            url=url,
            day=day or cited.get("date-released"),
        )
    except (OSError, KeyError, TypeError, yaml.YAMLError) as error:
        raise EntryError(f"{citation}: {error}; restore the file from the repository") from None


def responsible() -> dict[str, Any]:
    """What responsible.yaml says: description, uses, limits, biases and origin of the data."""
    said: dict[str, Any] = yaml.safe_load(RESPONSIBLE.read_text(encoding="utf-8"))
    return said


def _name(author: dict[str, str]) -> str:
    return author["name"] if "name" in author else f"{author['family-names']}, {author['given-names']}"
