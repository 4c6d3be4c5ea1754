"""Noun phrases of the categories that nobody wrote for this benchmark: WordNet's, and those of people who described objects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from ovman.language import noun

PHRASES = Path(__file__).with_name("phrases.yaml")
NOUN = "noun"
SOURCES = (NOUN, "wordnet", "people")


@dataclass(frozen=True, slots=True)
class Phrase:
    """A noun phrase without article. source: one of `SOURCES`."""

    text: str
    source: str


def list_phrases(category: str, path: Path = PHRASES) -> dict[str, tuple[Phrase, ...]]:
    """Return the phrases of a category by source; its noun under "noun" if the file has none of the category."""
    of_category = _read(path).get(category, {})
    found = {source: tuple(Phrase(text, source) for text in of_category.get(source) or ()) for source in SOURCES[1:]}
    return {source: phrases for source, phrases in found.items() if phrases} or {NOUN: (Phrase(noun(category), NOUN),)}


@cache
def _read(path: Path) -> Mapping[str, Mapping[str, Any]]:
    found: Mapping[str, Mapping[str, Any]] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return found
