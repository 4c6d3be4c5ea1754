""".zenodo.json: what Zenodo asks of an upload."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ovman.dataset.about import About


def zenodo(about: About, derived_from: Sequence[Mapping[str, str]]) -> dict[str, Any]:
    """The metadata of the deposit. derived_from: sources with `url`."""
    return {
        "title": f"{about.name}: {about.title}",
        "upload_type": "dataset",
        "description": f"<p>{escape(about.description)}</p>",
        "creators": [{"name": author} for author in about.authors],
        "license": about.licence.lower(),
        "access_right": "open",
        "keywords": list(about.keywords),
        "language": "eng",
        "version": about.version,
        "references": [f"{'; '.join(about.paper[1])}: {about.paper[0]}"],
        "related_identifiers": [
            {"identifier": source["url"], "relation": "isDerivedFrom", "scheme": "url"} for source in derived_from
        ],
        **({} if about.day is None else {"publication_date": about.day}),
    }
