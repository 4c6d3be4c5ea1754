"""Outcomes made up for the tests of what is derived from them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from ovman.analysis.outcomes import Outcome
from ovman.records.task import Relation

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
    **seen: Any,
) -> Outcome:
    """Make the outcome of one episode; relations take turns with the number. seen: distance_m, other_m, neighbour_m."""
    relation = ROUND[number % len(ROUND)]
    distance_m = None if outcome != "answered" else 0.5 if success else 3.0
    return Outcome(
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
        **{"distance_m": distance_m, **seen},
    )


def embodied(arm: str, number: int, success: bool, seed: int = 0, spl: float = 0.9, **known: Any) -> Outcome:
    """Make the run of the same episode as that of `static` with the same number and scene."""
    scene = known.pop("scene", "FloorPlan1")
    relation = ROUND[number % len(ROUND)]
    return Outcome(
        episode=f"{scene}/{relation}/{number:04d}",
        scene=scene,
        relation=relation,
        category="Chair",
        instances=2,
        alike=1,
        arm=arm,
        seed=seed,
        outcome="stopped",
        success=success,
        spl=spl * success,
        path_length_m=3.0,
        actions=20,
        **known,
    )


def named(rows: list[dict[str, Any]]) -> list[SimpleNamespace]:
    """Return rows whose columns are attributes."""
    return [SimpleNamespace(**row) for row in rows]


def over_all(rows: list[dict[str, Any]]) -> list[SimpleNamespace]:
    """Return the rows over all relations."""
    return [row for row in named(rows) if row.relation == "all"]
