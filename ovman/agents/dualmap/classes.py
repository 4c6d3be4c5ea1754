"""The classes that DualMap gives its observations: a name for every category of the floor plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.protocols import TextEncoder

SELDOM_MOVED = ("stool", "cabinet", "couch", "shelf", "armchair", "bathtub", "chair", "sofa", "table", "rack", "bed")
OFTEN_MOVED = ("box", "cup", "cushion", "lamp", "pillow", "bowl", "microwave", "plant")
"""DualMap's prototypes of furniture and of what stands on it, those of them that are words of the vocabulary: what an encoder was
not taught says nothing."""


def class_names() -> tuple[str, ...]:
    """The noun of every category that can be an instance. There is no "unknown": the detector finds things without classes, and
    the list has all that there is."""
    return tuple(noun(category) for category in SYNONYMS)


@dataclass(frozen=True, slots=True, eq=False)
class Classes:
    """names: of C classes; feature (C, K): their unit embeddings; low_mobility (C,) bool: furniture that seldom moves."""

    names: tuple[str, ...]
    feature: np.ndarray
    low_mobility: np.ndarray

    @staticmethod
    def of(encoder: TextEncoder, mobility_margin: float, least_cosine: float) -> Classes:
        """The classes as an encoder reads their names.

        A class is furniture that seldom moves if its name is at least so near to the word for some (least_cosine), and not
        nearer by more than the margin to a word for what is moved often. All words have much in common for a small text tower:
        the mean of the names is taken off first.
        """
        names = class_names()
        feature = encoder.texts(names)
        common = feature.mean(axis=0)

        def own(words: Sequence[str]) -> np.ndarray:
            off = encoder.texts(words) - common
            unit: np.ndarray = off / np.maximum(np.linalg.norm(off, axis=1, keepdims=True), np.finfo(np.float32).tiny)
            return unit

        seldom, often = ((own(names) @ own(words).T).max(axis=1) for words in (SELDOM_MOVED, OFTEN_MOVED))
        return Classes(names, feature, (seldom > least_cosine) & (seldom >= often - mobility_margin))
