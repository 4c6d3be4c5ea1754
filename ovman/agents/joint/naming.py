"""How likely a segment is what a noun means, beside every other noun of the vocabulary."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ovman.agents.joint.settings import Joint
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS


class Nouns:
    """The nouns of the vocabulary as an encoder has them. embedding: from a noun phrase to its unit embedding (K,)."""

    def __init__(self, embedding: Callable[[str], np.ndarray], constants: Joint) -> None:
        self._embedding, self._constants = embedding, constants
        self._phrases = tuple(dict.fromkeys(noun(category) for category in SYNONYMS))
        self._all = np.stack([np.asarray(embedding(phrase), np.float64) for phrase in self._phrases])

    @property
    def chance(self) -> float:
        """Log probability of a noun of which nothing is known."""
        return -float(np.log(len(self._phrases)))

    def log_probability(self, feature: np.ndarray, phrase: str) -> np.ndarray:
        """(S,) log probability that features (S, K) show what a noun phrase means; `chance` for features that are zero.

        The softmax over the vocabulary at the encoder's temperature, mixed with the uniform distribution: a noun that the encoder
        never learned to name is then as good as no noun, instead of evidence against everything.
        """
        if not len(feature):
            return np.zeros(0)
        others = self._all if phrase in self._phrases else np.vstack([self._all, self._embedding(phrase)])
        own = self._phrases.index(phrase) if phrase in self._phrases else len(self._phrases)
        scaled = feature @ others.T / self._constants.temperature
        scaled -= scaled.max(axis=1, keepdims=True)
        softmax = np.exp(scaled)
        share = softmax[:, own] / softmax.sum(axis=1)
        astray = self._constants.astray
        mixed: np.ndarray = np.log((1 - astray) * share + astray / len(others))
        return np.where(feature.any(axis=1), mixed, self.chance)
