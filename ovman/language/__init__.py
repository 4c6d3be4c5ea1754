"""Nouns and sentences of the benchmark. Stands alone."""
