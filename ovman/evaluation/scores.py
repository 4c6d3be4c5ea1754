"""Stage `scores`: judge measured rollouts (Eq. 4 and 5) by the constants of their episodes. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import UniformBox, UniformPick
from ovman.records.record import lines
from ovman.records.run import NOWHERE, Measured, Rollout, Score, Travelled
from ovman.records.task import Relation
from ovman.settings import Arm
from ovman.settings.benchmark import Success
from ovman.task import spl, success

_SCORED = ("episode", "arm", "seed", "outcome", *Travelled.model_fields, "trace")
"""Fields of a rollout that its score repeats."""


def run(arms: Iterable[Arm], episodes_file: Path, rollouts: Path, output: Path) -> None:
    """Judge the rollouts of a split's arms, files of one name in the folders `rollouts` and `output`.

    The rollouts of an arm that stops at a smaller budget are cut from another arm's.
    """
    episodes = {episode.id: episode for episode in Episode.load(episodes_file)}
    output.mkdir(parents=True, exist_ok=True)
    for arm in arms:
        cut = (cut_rollout(rollout, arm) for rollout in Rollout.read(rollouts / f"{arm.cut_from or arm.name}.jsonl"))
        scores = (score_rollout(rollout, episodes[rollout.episode], arm.any_instance) for rollout in cut)
        (output / f"{arm.name}.jsonl").write_text(lines(scores), encoding="utf-8")


def score_rollout(rollout: Rollout, episode: Episode, any_instance: bool = False) -> Score:
    """Return a rollout with its success and SPL.

    any_instance: Whether the agent's own task is to reach any instance of the category; the verdict on that is added.
    """
    constants = episode.protocol.success
    succeeds = is_success(rollout, episode.relation, constants, episode.rules.exclusive)
    return Score(
        **{name: getattr(rollout, name) for name in _SCORED},
        success=succeeds,
        spl=round(spl(succeeds, episode.shortest_path_m, rollout.path_length_m), 6),
        own_success=is_at_any_instance(rollout, constants) if any_instance else None,
    )


def cut_rollout(rollout: Rollout, arm: Arm) -> Rollout:
    """Return the rollout of another arm as that of an arm that has a smaller budget of actions and else does the same.

    Raises:
        ValueError: The run went on, and its path length at the smaller budget was not recorded.
    """
    if arm.cut_from is None or arm.budget is None:
        return rollout
    ended = rollout.outcome in ("stalled", "budget") and rollout.actions == arm.budget
    if rollout.actions < arm.budget or ended:
        return rollout.model_copy(update={"arm": arm.name})
    travelled = (rollout.path_at_m or {}).get(arm.budget)
    if travelled is None:
        raise ValueError(f"{rollout.episode}: {arm.cut_from} was not run for {arm.name}; make its rollouts again")
    spent = {"arm": arm.name, "outcome": "budget", "path_length_m": travelled, "actions": arm.budget}
    trace = None if rollout.trace is None else rollout.trace[: arm.budget]
    return rollout.model_copy(update=dict(NOWHERE) | spent | {"trace": trace})


def is_success(run: Measured, relation: Relation, constants: Success, exclusive: bool = False) -> bool:
    """Return whether a measured run succeeds (Eq. 4); a run that did not stop is a failure. exclusive: As for `success`."""
    return run.outcome == "stopped" and success(run.measurement, relation, constants, exclusive)


def is_at_any_instance(run: Measured, constants: Success) -> bool:
    """Return whether a run stopped within R of any instance of the category and with it in sight, whatever the relation."""
    if run.outcome != "stopped":
        return False
    return any(
        terms.box_distance_m <= constants.radius_m
        and any(terms.visible_px[pitch] >= constants.visible_px for pitch in constants.sweep_deg)
        for terms in (run.instances or {}).values()
    )


def is_right(point: Point, episode: Episode, radius_m: float) -> bool:
    """Return whether a predicted point lies within radius_m of the answer and nearer to it than to every rival of the episode."""
    distance_m = math.dist(point, episode.answer)
    return distance_m <= radius_m and all(distance_m < math.dist(point, rival) for rival in episode.rivals())


def best_stop(episodes: Sequence[Episode], radius_m: float = math.inf, spacing_m: float = 0.05) -> tuple[Point, float]:
    """Return the one point that is the right answer to the most of some episodes, and the share of them: the best fixed answer.

    The points are those of a square grid over all answers. An infinite radius leaves the rivals alone to decide, so no stop of a
    run succeeds in a larger share of episodes whose success is exclusive.
    """
    answers = np.array([episode.answer for episode in episodes])
    margin_m = min(radius_m, 1.0)
    axes = (
        np.arange(low - margin_m, high + margin_m, spacing_m) for low, high in zip(answers.min(0), answers.max(0), strict=True)
    )
    points = np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
    points = np.concatenate([points, answers])
    right = np.sum([_are_right(points, one.answer, radius_m, one.rivals()) for one in episodes], axis=0)
    best = int(np.argmax(right))
    return (float(points[best, 0]), float(points[best, 1])), float(right[best]) / len(episodes)


def success_probability(
    pick: UniformPick | UniformBox,
    answer: Point,
    radius_m: float,
    *,
    samples: int,
    generator: np.random.Generator,
    rivals: Sequence[Point] = (),
) -> float:
    """Return the probability that the picked point is within radius_m of the answer and nearer to it than to the rivals.

    For a UniformPick it is exact: the fraction of its candidates within the radius, 0 without any. For a UniformBox it is a Monte
    Carlo estimate: the fraction of ``samples`` >= 1 uniform positions, with a standard error of at most 0.5 / sqrt(samples).
    """
    if isinstance(pick, UniformPick):
        points = np.array(pick.candidates, dtype=np.float64).reshape(-1, 2)
        return float(_are_right(points, answer, radius_m, rivals).mean()) if len(points) else 0.0
    if samples < 1:
        raise ValueError(f"samples must be at least 1, not {samples}")
    points = generator.uniform((pick.x_min, pick.z_min), (pick.x_max, pick.z_max), size=(samples, 2))
    return float(_are_right(points, answer, radius_m, rivals).mean())


def _are_right(points: np.ndarray, answer: Point, radius_m: float, rivals: Sequence[Point]) -> np.ndarray:
    away_m = np.hypot(points[:, 0] - answer[0], points[:, 1] - answer[1])
    right: np.ndarray = away_m <= radius_m
    for x, z in rivals:
        right &= away_m < np.hypot(points[:, 0] - x, points[:, 1] - z)
    return right
