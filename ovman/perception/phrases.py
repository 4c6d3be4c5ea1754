"""A table of embedded phrases, beside the graph of the image tower that they were made with."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.atomic import replacing
from ovman.perception.array_file import ArrayFileError, read_arrays, write_arrays

SCHEMA = "ovman-phrases/1"


class UnknownPhraseError(ValueError):
    """A phrase that a table does not have."""


@dataclass(frozen=True, slots=True, eq=False)
class Phrases:
    """Unit embeddings (N, K) float32 of N phrases.

    source: SHA-256 of the weights that made them; made: versions of the libraries that did.
    """

    phrases: tuple[str, ...]
    feature: np.ndarray
    source: str
    made: Mapping[str, str]

    def rows(self, asked: Sequence[str]) -> np.ndarray:
        """The embeddings (M, K) of M phrases. UnknownPhraseError names the first one that is not there."""
        number = {phrase: row for row, phrase in enumerate(self.phrases)}
        for phrase in asked:
            if phrase not in number:
                raise UnknownPhraseError(phrase)
        return self.feature[[number[phrase] for phrase in asked]]

    def write(self, path: Path) -> None:
        """Write the table; equal tables have equal bytes."""
        of = np.array(json.dumps({"source": self.source, "made": self.made}))
        with replacing(path) as partial:
            write_arrays(partial, SCHEMA, {"phrases": np.array(self.phrases, str), "feature": self.feature, "of": of})

    @staticmethod
    def read(path: Path) -> Phrases:
        """A table. FileNotFoundError, and ArrayFileError in one line for a file that is damaged or none."""
        held = read_arrays(path, SCHEMA)
        try:
            of = json.loads(str(held["of"]))
            found = Phrases(tuple(map(str, held["phrases"])), held["feature"], of["source"], of["made"])
        except (KeyError, ValueError, TypeError):
            raise ArrayFileError(f"{path}: it does not say what it was made of; make it again with `ovman export`") from None
        if found.feature.shape != (len(found.phrases), *found.feature.shape[-1:]) or found.feature.dtype != np.float32:
            raise ArrayFileError(f"{path}: it has not one embedding a phrase; make it again with `ovman export`")
        return found
