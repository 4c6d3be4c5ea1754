"""Retrieval: the rank of the right category among all categories of a scene, by similarity of crops and nouns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class Ranks:
    """Ranks of N crops. own (N,): how many categories come before the right one if each goes by its own noun; 0 is first.

    synonyms: per crop the same with each synonym of the right category instead of its own noun (S,); S is 0 for a
    category without synonyms. choices (N,): how many categories there were.
    """

    own: np.ndarray
    synonyms: tuple[np.ndarray, ...]
    choices: np.ndarray

    def top(self, k: int) -> np.ndarray:
        """Return (N,) 1.0 where the right category is among the first k."""
        return (self.own < k).astype(float)

    def top_by_synonym(self, k: int) -> np.ndarray:
        """Return (N,) the share of the synonyms by which the right category is among the first k; NaN without synonyms."""
        return np.array([np.mean(ranks < k) if len(ranks) else np.nan for ranks in self.synonyms])

    def chance(self, k: int) -> np.ndarray:
        """Return (N,) the expected value for a random order."""
        return np.minimum(k / self.choices, 1.0)


def rank_categories(
    features: np.ndarray,
    categories: Sequence[str],
    present: Sequence[str],
    nouns: Mapping[str, Sequence[str]],
    text: Mapping[str, np.ndarray],
) -> Ranks:
    """Rank the right categories of N crops, of true or of detected masks.

    features (N, K): unit embeddings of the crops, categories: what each shows; present: the categories to choose from. nouns: of
    each category, its own noun first, then the synonyms; text: unit embedding (K,) of every noun. A category that is as similar
    as the right one comes before it, unless it goes by the same phrase: a noun that several categories share is right for each.
    """
    order = sorted(set(present))
    features = np.asarray(features, float)
    of_noun = np.stack([text[nouns[category][0]] for category in order]).astype(float) if order else np.zeros((0, 0))
    own = np.zeros(len(features), int)
    by_synonym: list[np.ndarray] = [np.zeros(0, int)] * len(features)
    labels = np.array(categories, object)
    for category in sorted(set(categories)):
        rows = np.flatnonzero(labels == category)
        others = [i for i, other in enumerate(order) if other != category]
        against = features[rows] @ of_noun[others].T
        phrases = [nouns[order[i]][0] for i in others]

        before = partial(_count_before, features[rows], against, phrases, text)
        own[rows] = before(nouns[category][0])
        renamed = np.stack([before(phrase) for phrase in nouns[category][1:]] or [np.zeros(len(rows), int)], axis=1)
        for row, of_row in zip(rows, renamed[:, : len(nouns[category]) - 1], strict=True):
            by_synonym[row] = of_row
    return Ranks(own, tuple(by_synonym), np.full(len(features), len(order)))


def _count_before(
    features: np.ndarray, against: np.ndarray, phrases: Sequence[str], text: Mapping[str, np.ndarray], phrase: str
) -> np.ndarray:
    """Return (R,) how many other categories come before the right one, if that goes by `phrase`.

    features (R, K): of the crops; against (R, C): similarities to the nouns `phrases` of the C other categories.
    """
    rival = np.array([other != phrase for other in phrases], bool)
    ahead: np.ndarray = (against[:, rival] >= (features @ text[phrase].astype(float))[:, None]).sum(axis=1)
    return ahead
