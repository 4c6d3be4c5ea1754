"""The single-visit baseline: the same candidates with no retained past.

It is a stochastic pick rather than a realised policy, so the agent's side says what it picks from and the evaluator's side
computes the probability that such a pick succeeds. Source: the single-visit baseline of the paper's problem formulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.reference.association import positions
from ovman.task import Query, Relation

if TYPE_CHECKING:
    from ovman.evaluation.context import Recorded

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class UniformPick:
    """One of the candidates, each as likely: floor-plane points (x, z) in metres. Without candidates there is no answer."""

    candidates: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class UniformBox:
    """A uniform position in an axis-aligned floor-plane rectangle from (x_min, z_min) to (x_max, z_max), metres."""

    x_min: float
    z_min: float
    x_max: float
    z_max: float

    def __post_init__(self) -> None:
        if not (self.x_min <= self.x_max and self.z_min <= self.z_max):
            raise ValueError(f"a box runs from its smallest to its largest corner, not {self}")


def single_visit(relation: Relation, tracks_2: Sequence[ArrayLike], reachable: ArrayLike) -> UniformPick | UniformBox:
    """What the single-visit agent picks from.

    tracks_2: for each grounded instance of visit 2 its floor-plane positions (T, 2) in metres in the order they were seen (one
    row for an instance that stands still); reachable (K, 2), K >= 1: positions that the agent can reach. Current relations are
    answered with an instance of visit 2 at its last track point, past ones, for which the visit holds no evidence, with a
    position in the bounding box of what is reachable.

    Raises ValueError where a past relation is asked and nothing is reachable.
    """
    if Relation(relation).past:
        points = positions(reachable, "reachable")
        if not len(points):
            raise ValueError("the reachable positions are empty: a past relation has no box to answer from")
        (x_min, z_min), (x_max, z_max) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return UniformBox(x_min, z_min, x_max, z_max)
    tracks = (positions(track, "track") for track in tracks_2)
    return UniformPick(tuple(sorted((float(track[-1, 0]), float(track[-1, 1])) for track in tracks if len(track))))


def predict(query: Query, recorded: Recorded) -> tuple[UniformPick | UniformBox, None]:
    """The static arm positions_single_visit."""
    tracks = [instance.track for instance in recorded.world("second").category(query.category)]
    return single_visit(query.relation, tracks, recorded.reachable), None


def success_probability(
    pick: UniformPick | UniformBox, answer: Point, radius_m: float, *, samples: int, generator: np.random.Generator
) -> float:
    """Probability that the picked point lies within radius_m of the answer (x, z) on the floor plane.

    Exact for a UniformPick: the fraction of its candidates within the radius, 0 without any. A Monte Carlo estimate for a
    UniformBox: the fraction of ``samples`` >= 1 uniform positions, its standard error at most 0.5 / sqrt(samples).
    """
    if isinstance(pick, UniformPick):
        points = positions(pick.candidates, "candidates")
        return float(_within(points, answer, radius_m).mean()) if len(points) else 0.0
    if samples < 1:
        raise ValueError(f"samples must be at least 1, not {samples}")
    points = generator.uniform((pick.x_min, pick.z_min), (pick.x_max, pick.z_max), size=(samples, 2))
    return float(_within(points, answer, radius_m).mean())


def _within(points: np.ndarray, answer: Point, radius_m: float) -> np.ndarray:
    return np.hypot(points[:, 0] - answer[0], points[:, 1] - answer[1]) <= radius_m
