"""What CoW's released runner wrote of an episode, and what was measured at its stop, as a rollout.

The runner's own success is not read: its stop is judged as every arm's is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.records.episode import Episode
from ovman.records.record import Record, RecordError
from ovman.records.run import Rollout
from ovman_released.cow_controller import ARM, STOP, Verdict
from ovman_released.cow_episodes import runner_name

SAME_M = 1e-3
"""Farthest distance between the runner's last pose and the place where the stop was measured, metres."""


class _Pose(Record):
    x: float
    z: float


class _Taken(Record):
    action: str


class _Metrics(Record):
    trajectory: tuple[_Pose, ...]
    actions_taken: tuple[_Taken, ...]


class _RunnerFile(Record):
    episode_metrics: _Metrics


@dataclass(frozen=True)
class Walk:
    """A run of the released agent.

    positions: on the floor plane (x, z) in metres from the start on, one more than actions; stopped: the last action is Stop.
    """

    positions: tuple[tuple[float, float], ...]
    stopped: bool

    @property
    def path_length_m(self) -> float:
        """Length of the path, metres."""
        return math.fsum(math.dist(a, b) for a, b in zip(self.positions, self.positions[1:], strict=False))

    @property
    def actions(self) -> int:
        """Number of actions; the stop is none."""
        return len(self.positions) - 1 - self.stopped

    @staticmethod
    def read(path: Path) -> Walk:
        """From the runner's file. Raises RecordError in one line where it is not what the released runner writes."""
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise RecordError(f"{path}: cannot be read ({error}); run the released system again") from None
        metrics = _RunnerFile.from_json(record, str(path)).episode_metrics
        poses, actions = metrics.trajectory, [taken.action for taken in metrics.actions_taken]
        if len(poses) != len(actions) + 1:
            complaint = f"{len(poses)} poses for {len(actions)} actions"
            raise RecordError(f"{path}: {complaint}; there must be one pose more, run the released system again")
        return Walk(tuple((pose.x, pose.z) for pose in poses), bool(actions) and actions[-1] == STOP)


def imported(episode: Episode, seed: int, walk: Walk, verdict: Verdict) -> Rollout:
    """The rollout of a walk and its verdict. Raises ValueError where they are of different runs."""
    if walk.stopped != verdict.stopped or walk.stopped != (verdict.stop is not None):
        raise ValueError(f"{episode.id}: the runner and the test at the stop do not agree on whether it stopped; run it again")
    if verdict.stop is not None:
        stop = verdict.stop.x, verdict.stop.z
        if math.dist(stop, walk.positions[-1]) > SAME_M:
            raise ValueError(f"{episode.id}: measured at {stop}, stopped at {walk.positions[-1]}; run it again")
    return Rollout(
        episode=episode.id,
        arm=ARM,
        seed=seed,
        outcome="stopped" if walk.stopped else "budget",
        stop=verdict.stop,
        box_distance_m=verdict.box_distance_m,
        answer_distance_m=verdict.answer_distance_m,
        navigable_distance_m=verdict.navigable_distance_m,
        visible_px=verdict.visible_px,
        path_length_m=round(walk.path_length_m, 4),
        actions=walk.actions,
        instances=verdict.instances,
    )


def collected(results: Path, verdicts: Path, episodes: Sequence[Episode], seed: int) -> list[Rollout]:
    """The rollouts of all episodes in their order. Raises ValueError in one line where one is missing or broken."""
    measured = {verdict.name: verdict for verdict in Verdict.read(verdicts)}
    rollouts = []
    for episode in episodes:
        name = runner_name(episode)
        if name not in measured:
            raise ValueError(f"{episode.id}: the released runner left no verdict in {verdicts}; run it again")
        rollouts.append(imported(episode, seed, Walk.read(results / f"{name}.json"), measured[name]))
    return rollouts
