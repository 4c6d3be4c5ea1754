"""The instances of a visit, as REACT's object nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ovman.agents.reference.grounding import similarities
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.object_map import ObjectMap


@dataclass(frozen=True, slots=True, eq=False)
class Instances:
    """N instances. place (N, 2): floor-plane positions in metres; feature (N, K): unit embeddings; kind (N,): numbers of their
    classes; views (N,): in how many views each was seen.
    """

    place: np.ndarray
    feature: np.ndarray
    kind: np.ndarray
    views: np.ndarray

    def __len__(self) -> int:
        return len(self.place)


def class_features(embedding: Callable[[str], np.ndarray]) -> np.ndarray:
    """Unit embeddings (C, K) of the classes: the noun of every category of the floor plans, in their order."""
    return np.stack([embedding(noun(category)) for category in SYNONYMS])


def instances(objects: ObjectMap, classes: np.ndarray) -> Instances:
    """The objects of a visit's map; the class (C, K) of each is the one whose name is most similar, the first in a tie."""
    kind = np.array([int(similarities(classes, feature).argmax()) for feature in objects.f], np.int64)
    return Instances(objects.p, objects.f, kind, np.array([len(track) for track in objects.tracks], np.int64))
