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
"""DualMap's prototypes of furniture and of movable objects, restricted to words that the encoder was trained on."""


def class_names() -> tuple[str, ...]:
    """The noun of every category of instances. The list is complete, so that it needs no class "unknown"."""
    return tuple(noun(category) for category in SYNONYMS)


@dataclass(frozen=True, slots=True, eq=False)
class Classes:
    """The C classes.

    names: of the classes; feature (C, K): unit embeddings of the names; low_mobility (C,) bool: furniture that seldom moves.
    """

    names: tuple[str, ...]
    feature: np.ndarray
    low_mobility: np.ndarray

    @staticmethod
    def of(encoder: TextEncoder, mobility_margin: float, least_cosine: float) -> Classes:
        """The classes with an encoder's embeddings.

        A class has low mobility if its greatest cosine to the words of SELDOM_MOVED is above `least_cosine` and at most
        `mobility_margin` below its greatest cosine to those of OFTEN_MOVED. The mean embedding of the names is subtracted first,
        because a small text tower maps all words close together.
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
