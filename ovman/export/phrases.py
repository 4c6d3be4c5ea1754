"""The phrases that the benchmark asks a text tower for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ovman.agents.cow.localiser import prompt
from ovman.language.vocabulary import SYNONYMS, all_nouns

Read = Callable[[Sequence[str]], np.ndarray]


def embedded(read: Read, further: Sequence[str] = ()) -> tuple[tuple[str, ...], np.ndarray]:
    """All phrases, and their unit embeddings (N, K): the nouns of the vocabulary, CoW's prompts, and `further` ones.

    Nouns are read together, in the order of the alphabet, and all others one by one: a phrase's company changes the last bits.
    """
    nouns = tuple(sorted(set(all_nouns())))
    prompts = [prompt(category) for category in (*SYNONYMS, "Floor")]
    others = tuple(phrase for phrase in dict.fromkeys([*prompts, *further]) if phrase not in nouns)
    return nouns + others, np.concatenate([read(nouns), *(read([phrase]) for phrase in others)])
