"""Verdicts: success of a run (Eq. 4), success on an agent's own task, and the probability that a stochastic pick succeeds."""

from __future__ import annotations

import numpy as np

from ovman.records.prediction import UniformBox, UniformPick
from ovman.records.relation import Relation
from ovman.records.run import Measured
from ovman.settings.benchmark import Success
from ovman.task import success


def judged(run: Measured, relation: Relation, constants: Success) -> bool:
    """Success (Eq. 4) of a measured run; a run that did not stop is a failure."""
    return run.outcome == "stopped" and success(run.measurement, relation, constants)


def any_instance(run: Measured, constants: Success) -> bool:
    """Whether a run ends within R of any instance of the category and with it in sight, the relation aside.

    A run that did not stop is a failure.
    """
    if run.outcome != "stopped":
        return False
    return any(
        found.box_distance_m <= constants.radius_m
        and any(found.visible_px[pitch] >= constants.visible_px for pitch in constants.sweep_deg)
        for found in (run.instances or {}).values()
    )


def success_probability(
    pick: UniformPick | UniformBox, answer: tuple[float, float], radius_m: float, *, samples: int, generator: np.random.Generator
) -> float:
    """Probability that the picked point lies within radius_m of the answer (x, z) on the floor plane.

    Exact for a UniformPick: the fraction of its candidates within the radius, 0 without any. A Monte Carlo estimate for a
    UniformBox: the fraction of ``samples`` >= 1 uniform positions, its standard error at most 0.5 / sqrt(samples).
    """
    if isinstance(pick, UniformPick):
        points = np.array(pick.candidates, dtype=np.float64).reshape(-1, 2)
        return float(_within(points, answer, radius_m).mean()) if len(points) else 0.0
    if samples < 1:
        raise ValueError(f"samples must be at least 1, not {samples}")
    points = generator.uniform((pick.x_min, pick.z_min), (pick.x_max, pick.z_max), size=(samples, 2))
    return float(_within(points, answer, radius_m).mean())


def _within(points: np.ndarray, answer: tuple[float, float], radius_m: float) -> np.ndarray:
    return np.hypot(points[:, 0] - answer[0], points[:, 1] - answer[1]) <= radius_m
