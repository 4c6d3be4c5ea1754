"""The arms of the evaluation as section `arms` of config.yaml has them. Predictions, executions and the rows of the tables are
derived from them.

Imports nothing heavy: the workflow reads it before any job starts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any


class Kind(StrEnum):
    """How an arm is judged: STATIC by the point that it predicts, EMBODIED by where it stops."""

    STATIC = "static"
    EMBODIED = "embodied"


class Source(StrEnum):
    """Whether an arm finds something out itself or is given the truth about it."""

    OWN = "own"
    HANDED = "handed"


class Need(StrEnum):
    """What an arm is given beside the query and its observations.

    TOURS: the recorded frames of both visits; MAPS: the maps that the reference agent's perception made of them, and the
    embeddings of nouns; NETWORKS: the detector and the encoder themselves; DUALMAP: DualMap's maps, and the embeddings of nouns.
    """

    TOURS = "tours"
    MAPS = "maps"
    NETWORKS = "networks"
    DUALMAP = "dualmap"


@dataclass(frozen=True, slots=True)
class Arm:
    """An arm. The fields are those of `ovman.models.settings.sections.ArmEntry`, where their meaning is.

    name: in file names and records. system, memory: what the tables call it; empty in a job of the arm, which has no use for
    them. marks: the budgets at which other arms cut this one's runs.
    """

    name: str
    kind: Kind
    agent: str
    system: str = ""
    memory: str = ""
    grounding: Source = Source.OWN
    positions: Source = Source.OWN
    answer: Source = Source.OWN
    needs: tuple[Need, ...] = ()
    constants: tuple[str, ...] = ()
    executes: str | None = None
    expected: bool = False
    runs: int = 1
    embodiment: str = "default"
    released: str | None = None
    any_instance: bool = False
    budget: int | None = None
    cut_from: str | None = None
    marks: tuple[int, ...] = ()

    @staticmethod
    def of(entry: Mapping[str, Any]) -> Arm:
        """The arm of an entry with its name, as the canonical text of a stage has it."""
        converted: dict[str, Any] = {"kind": Kind} | dict.fromkeys(("grounding", "positions", "answer"), Source)
        converted |= {"needs": _needs, "constants": tuple, "marks": tuple}
        known = {field.name for field in fields(Arm)}
        return Arm(**{k: converted.get(k, lambda value: value)(v) for k, v in entry.items() if k in known})


def _needs(values: Iterable[str]) -> tuple[Need, ...]:
    return tuple(Need(value) for value in values)


def table(entries: Mapping[str, Any] | Iterable[Mapping[str, Any]]) -> tuple[Arm, ...]:
    """All arms in the order of config.yaml. entries: section `arms` of the settings, or as a stage's constants have it."""
    if isinstance(entries, Mapping):
        entries = [{"name": name, **dict(entry)} for name, entry in entries.items()]
    return tuple(map(Arm.of, entries))


def of_kind(arms: Iterable[Arm], kind: Kind) -> tuple[Arm, ...]:
    """The arms of one kind, in their order."""
    return tuple(arm for arm in arms if arm.kind is kind)


def named(arms: Sequence[Arm], name: str) -> Arm:
    """The arm of that name. Raises KeyError that lists the names there are."""
    for arm in arms:
        if arm.name == name:
            return arm
    raise KeyError(f"{name!r} is not an arm; there are {', '.join(arm.name for arm in arms)}")
