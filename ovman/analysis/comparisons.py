"""Which arms are compared with which, once. Tests, the error budget and their tables are derived from these lists.

Arms that are not there are not compared: the workflow may run without the baselines, and the systems as they were released are
only there where somebody has them.
"""

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
    """Two arms over the same episodes. A win is an episode on which `arm` succeeds and `baseline` does not.

    released: the pair has an arm that runs the published system, which most who run the workflow do not have.
    """

    arm: str
    baseline: str
    title: str
    released: bool = False


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
    Pair("two_visits_embodied", "cow", "two visits against CoW, embodied"),
    Pair("two_visits_embodied", "cow_500", "two visits against CoW with 500 actions, embodied"),
    Pair("two_visits_embodied", "cow_released", "two visits against CoW (released), embodied", released=True),
)

# The handovers that both systems have, and what they are called in titles.
_RUNGS_OF_BOTH = {"": "", "grounding_": ", grounding handed over"}


def _pairings(dualmap: str, name: str, released: bool) -> tuple[Pair, ...]:
    """DualMap's two readings against each other, and the reference agent against either. dualmap: what its arms begin with."""
    return tuple(
        Pair(f"{handed}{arm}", f"{handed}{dualmap}_{baseline}", title.format(name) + words, released)
        for handed, words in _RUNGS_OF_BOTH.items()
        for arm, baseline, title in (
            (f"{dualmap}_two_visits", "maintained", "{0} read as two visits against {0} read as one maintained map"),
            (AGENT, "maintained", "two visits against {0} read as one maintained map"),
            (AGENT, "two_visits", "two visits against {0} read as two visits"),
        )
    )


PAIRINGS: tuple[Pair, ...] = (
    *_pairings("dualmap", "DualMap", released=False),
    *_pairings("dualmap_released", "DualMap (released)", released=True),
)
"""Pairs of static arms of which at least one has several runs: every run of the one is set against every run of the other."""


def among(arms: Iterable[str], candidates: Iterable[Pair] = PAIRS) -> tuple[list[Pair], list[str]]:
    """Those of the candidates of which both arms are among `arms`, and for each of the others a line that says which arm is not.

    Nothing is said of pairs with a released system, which is seldom there.
    """
    there = set(arms)
    pairs, left_out = [], []
    for pair in candidates:
        lacking = [name for name in (pair.arm, pair.baseline) if name not in there]
        if not lacking:
            pairs.append(pair)
        elif not pair.released:
            left_out.append(f"not compared: {pair.title}; there is no arm {' and no '.join(lacking)}")
    return pairs, left_out
