"""Nouns and sentences of the benchmark."""

from ovman.language.noun import noun
from ovman.language.sentence import sentence

__all__ = ["noun", "sentence"]
