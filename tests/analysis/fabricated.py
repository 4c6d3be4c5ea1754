"""Outcomes made up for the tests of what is derived from them."""

from __future__ import annotations

from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.task import Relation

ROUND = tuple(Relation)


def static(
    arm: str,
    number: int,
    success: float,
    outcome: str = "answered",
    *,
    instances: int = 2,
    alike: int = 1,
    scene: str = "FloorPlan1",
    seed: int = 0,
    **seen,
):
    """The outcome of one episode; relations take turns with the number. seed: the run of an arm with several. seen: distance_m,
    other_m."""
    relation = ROUND[number % len(ROUND)]
    seen = {"distance_m": 0.5 if success else 3.0, **seen} if outcome == "answered" else {"distance_m": None, **seen}
    return StaticOutcome(
        episode=f"{scene}/{relation}/{number:04d}",
        scene=scene,
        relation=relation,
        category="Chair",
        instances=instances,
        alike=alike,
        arm=arm,
        seed=seed,
        outcome=outcome,
        reason="no_candidate" if outcome == "abstained" else None,
        success=float(success),
        **seen,
    )


def embodied(
    arm: str,
    number: int,
    success: bool,
    seed: int = 0,
    spl: float = 0.9,
    *,
    own_success: bool | None = None,
    scene: str = "FloorPlan1",
):
    """The run of the same episode as that of ``static`` with the same number and scene."""
    relation = ROUND[number % len(ROUND)]
    return EmbodiedOutcome(
        f"{scene}/{relation}/{number:04d}",
        scene,
        relation,
        "Chair",
        2,
        1,
        arm,
        seed,
        "stopped",
        success,
        spl * success,
        3.0,
        20,
        own_success,
    )
