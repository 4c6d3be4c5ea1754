"""Which arms are compared with which, once. Tests, the error budget and their tables are derived from these lists."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

AGENT = "two_visits"
"""The reference agent as it stands: the arm whose failures are told apart."""


@dataclass(frozen=True, slots=True)
class Rung:
    """One rung of the error budget: the static two-visit arm that is handed what the rung is called after."""

    arm: str
    title: str


@dataclass(frozen=True, slots=True)
class Pair:
    """Two arms over the same episodes. A win is an episode on which `arm` succeeds and `baseline` does not."""

    arm: str
    baseline: str
    title: str


# Each rung hands over one source of error more (the paper's Fig. diag a). The last one, the answer itself, needs no arm.
RUNGS: tuple[Rung, ...] = (
    Rung("two_visits", "own"),
    Rung("grounding_two_visits", "grounding handed over"),
    Rung("positions_two_visits", "positions handed over"),
)
ANSWER_GIVEN = "answer given"

PAIRS: tuple[Pair, ...] = (
    Pair("two_visits", "single_visit", "two visits against one"),
    Pair("grounding_two_visits", "grounding_single_visit", "two visits against one, grounding handed over"),
    Pair("positions_two_visits", "positions_single_visit", "two visits against one, positions handed over"),
    *(Pair(upper.arm, lower.arm, f"{upper.title} against {lower.title}") for lower, upper in pairwise(RUNGS)),
    Pair("two_visits_embodied", "single_visit_embodied", "two visits against one, embodied"),
    Pair("two_visits_oracle_positions", "two_visits_embodied", "positions handed over against own, embodied"),
)


def among(arms: Iterable[str]) -> tuple[list[Pair], list[str]]:
    """The pairs of which both arms are among `arms`, and for each of the others a line that says which arm is not."""
    there = set(arms)
    pairs, left_out = [], []
    for pair in PAIRS:
        lacking = [name for name in (pair.arm, pair.baseline) if name not in there]
        if lacking:
            left_out.append(f"not compared: {pair.title}; there is no arm {' and no '.join(lacking)}")
        else:
            pairs.append(pair)
    return pairs, left_out
