"""Surface forms, and those that the parser is evaluated with, which was written without them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from ovman.language import RELATIONS, is_plural
from ovman.language.vocabulary import nouns

HELD_OUT = Path(__file__).with_name("held_out.yaml")


@dataclass(frozen=True, slots=True)
class Form:
    """A sentence with one "{noun}" in it, for a singular and for a plural noun phrase."""

    singular: str
    plural: str

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
    """Read a YAML file with "origin", and "forms" with a list per relation, of texts or {"singular", "plural"}."""
    tree = yaml.safe_load(path.read_text(encoding="utf-8"))
    forms = {
        relation: tuple(Form(one, one) if isinstance(one, str) else Form(**one) for one in tree["forms"][relation])
        for relation in RELATIONS
    }
    return HeldOut(" ".join(tree["origin"].split()), forms)
