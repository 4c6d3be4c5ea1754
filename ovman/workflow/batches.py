"""Which scenes one job of an embodied arm drives in, so that one start of Python and of the simulator serves several.

A batch has a rule of its own, since all files of a rule have the same wildcards. Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Batch:
    """Several scenes of one job. number: from 1, in the rule's name; splits: those that have these scenes as a batch."""

    number: int
    splits: tuple[str, ...]
    scenes: tuple[str, ...]

    @property
    def name(self) -> str:
        """Its first and last scene, in the names of its log and of its benchmark; no other batch of a split has the same."""
        return f"{self.scenes[0]}-{self.scenes[-1]}"


def batches(scenes_of: Mapping[str, Sequence[str]], size: int) -> tuple[Batch, ...]:
    """The batches of several scenes: in each split, its scenes in their order by `size`. One scene that is left over is in none.

    scenes_of: the scenes of each split. Splits with the same scenes share their batches.
    """
    found: dict[tuple[str, ...], list[str]] = {}
    for split, scenes in scenes_of.items():
        for start in range(0, len(scenes), size):
            if len(part := tuple(scenes[start : start + size])) > 1:
                found.setdefault(part, []).append(split)
    return tuple(Batch(number, tuple(splits), part) for number, (part, splits) in enumerate(found.items(), 1))
