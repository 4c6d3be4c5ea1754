"""Surface forms, and those that the parser is evaluated with, which was written without them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import yaml

from ovman.language.noun import is_plural
from ovman.language.sentence import RELATIONS
from ovman.language.vocabulary import nouns

HELD_OUT = Path(__file__).with_name("held_out.yaml")


@dataclass(frozen=True, slots=True)
class Form:
    """A sentence with one "{noun}" in it, for a singular and for a plural noun phrase. Raises ValueError for other braces."""

    singular: str
    plural: str

    def __post_init__(self) -> None:
        for text in (self.singular, self.plural):
            if text.count("{noun}") != 1 or text.count("{") != 1 or text.count("}") != 1:
                raise ValueError(f'a form has one "{{noun}}" and no other braces: {text!r}')

    def fill(self, noun: str) -> str:
        """Return the sentence about a noun phrase."""
        return (self.plural if is_plural(noun) else self.singular).replace("{noun}", noun)


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Held-out forms by relation. origin: who wrote them, and what the author knew of the parser, as a clause."""

    origin: str
    forms: Mapping[str, tuple[Form, ...]]

    def draw(self, relation: str, category: str, generator: np.random.Generator) -> tuple[str, str]:
        """Draw a noun of the category, one of `nouns`, and a sentence about it; nouns and forms are equally likely."""
        said = nouns(category)
        noun = said[int(generator.integers(len(said)))]
        forms = self.forms[relation]
        return noun, forms[int(generator.integers(len(forms)))].fill(noun)


def read_held_out(path: Path = HELD_OUT) -> HeldOut:
    """Read a YAML file with "origin", and "forms" with a list per relation, of texts or {"singular", "plural"}.

    Raises:
        ValueError: One line that names the file, the key and the remedy.
    """
    with path.open(encoding="utf-8") as file:
        tree = yaml.safe_load(file)
    if not isinstance(tree, Mapping) or set(tree) != {"origin", "forms"} or not isinstance(tree["origin"], str):
        raise ValueError(f'{path}: must have "origin", a text, and "forms", and nothing else')
    if not isinstance(tree["forms"], Mapping) or set(tree["forms"]) != set(RELATIONS):
        raise ValueError(f'{path}: "forms" must have a list for each of {", ".join(RELATIONS)}, and nothing else')
    forms = {relation: tuple(_forms(path, relation, tree["forms"][relation])) for relation in RELATIONS}
    return HeldOut(" ".join(tree["origin"].split()), MappingProxyType(forms))


def _forms(path: Path, relation: str, entries: Any) -> list[Form]:
    if not isinstance(entries, list) or not entries:
        raise ValueError(f"{path}: forms.{relation} must be a list of sentences")
    forms = []
    for number, entry in enumerate(entries, 1):
        place = f"{path}: forms.{relation}, entry {number}"
        texts = (entry, entry) if isinstance(entry, str) else ()
        if isinstance(entry, Mapping) and set(entry) == {"singular", "plural"}:
            texts = (entry["singular"], entry["plural"])
        if not texts or not all(isinstance(text, str) for text in texts):
            raise ValueError(f'{place}: must be a sentence, in quotes if it has a colon, or "singular" and "plural"')
        try:
            forms.append(Form(*texts))
        except ValueError as error:
            raise ValueError(f"{place}: {error}") from None
    return forms
