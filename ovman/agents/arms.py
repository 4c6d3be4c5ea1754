"""Every arm of the evaluation, once. Predictions, executions and the rows of the tables are derived from this table.

Imports nothing heavy: the workflow reads it before any job starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Kind(StrEnum):
    """How an arm is judged: STATIC by the point that it predicts, EMBODIED by where it stops."""

    STATIC = "static"
    EMBODIED = "embodied"


class Source(StrEnum):
    """Whether an arm finds something out itself or is given the truth about it."""

    OWN = "own"
    HANDED = "handed"


@dataclass(frozen=True, slots=True)
class Arm:
    """name: in file names and records. system: the row's title in the tables (an embodied arm's "agent").

    memory: what it keeps of the two visits. grounding, positions: own, or handed over as a diagnostic. executes: the static arm
    whose predictions an embodied arm drives to, or picks its goal from where they are a stochastic pick; None where it is given
    the answer. expected: its static success is the expectation over a stochastic pick, not a realised answer.
    """

    name: str
    kind: Kind
    system: str
    memory: str
    grounding: Source
    positions: Source
    executes: str | None = None
    expected: bool = False


# In the order of the tables.
ARMS: tuple[Arm, ...] = (
    Arm(
        "single_visit",
        Kind.STATIC,
        system="ours (reference)",
        memory="single visit",
        grounding=Source.OWN,
        positions=Source.OWN,
        expected=True,
    ),
    Arm(
        "two_visits",
        Kind.STATIC,
        system="ours (reference)",
        memory="two visits",
        grounding=Source.OWN,
        positions=Source.OWN,
    ),
    Arm(
        "grounding_single_visit",
        Kind.STATIC,
        system="ours (reference)",
        memory="single visit",
        grounding=Source.HANDED,
        positions=Source.OWN,
        expected=True,
    ),
    Arm(
        "grounding_two_visits",
        Kind.STATIC,
        system="ours (reference)",
        memory="two visits",
        grounding=Source.HANDED,
        positions=Source.OWN,
    ),
    Arm(
        "positions_single_visit",
        Kind.STATIC,
        system="ours (reference)",
        memory="single visit",
        grounding=Source.HANDED,
        positions=Source.HANDED,
        expected=True,
    ),
    Arm(
        "positions_two_visits",
        Kind.STATIC,
        system="ours (reference)",
        memory="two visits",
        grounding=Source.HANDED,
        positions=Source.HANDED,
    ),
    Arm(
        "single_visit_embodied",
        Kind.EMBODIED,
        system="ours, 1 visit",
        memory="single visit",
        grounding=Source.OWN,
        positions=Source.OWN,
        executes="single_visit",
    ),
    Arm(
        "two_visits_embodied",
        Kind.EMBODIED,
        system="ours, 2 visits",
        memory="two visits",
        grounding=Source.OWN,
        positions=Source.OWN,
        executes="two_visits",
    ),
    Arm(
        "two_visits_oracle_positions",
        Kind.EMBODIED,
        system="ours, oracle pos",
        memory="two visits",
        grounding=Source.HANDED,
        positions=Source.HANDED,
        executes="positions_two_visits",
    ),
    Arm(
        "oracle_check",
        Kind.EMBODIED,
        system="oracle check",
        memory="the answer",
        grounding=Source.HANDED,
        positions=Source.HANDED,
    ),
)


def of_kind(kind: Kind) -> tuple[Arm, ...]:
    """The arms of one kind, in the order of the tables."""
    return tuple(arm for arm in ARMS if arm.kind is kind)


def named(name: str) -> Arm:
    """The arm of that name. Raises KeyError that lists the names there are."""
    for arm in ARMS:
        if arm.name == name:
            return arm
    raise KeyError(f"{name!r} is not an arm; there are {', '.join(arm.name for arm in ARMS)}")
