"""Stage `nouns`: embeds every noun phrase of the vocabulary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.perception.networks import encoder_of
from ovman.perception.records import write_nouns
from ovman.settings import Settings


def run(phrases: Sequence[str], constants: Settings, output: Path) -> None:
    """Writes the unit embeddings of `phrases`, sorted, each once. Raises WeightsError."""
    distinct = sorted(set(phrases))
    features = encoder_of(constants.perception).texts(distinct)
    write_nouns(output, dict(zip(distinct, features, strict=True)))
    print(f"{len(distinct)} noun phrases", flush=True)
