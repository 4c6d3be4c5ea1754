"""Where an agent went: the actions of recorded runs driven again, and the pose after each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from ovman.agents.interface import LETTERS
from ovman.entry.manifest import read_manifest
from ovman.entry.replay import ACTIONS, replay_settings
from ovman.entry.run_files import read_runs, runs_path
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.report.show.verdicts import Drive, Pose
from ovman.runner import Run, open_env, open_session
from ovman.settings import Settings
from ovman.sim.session import Session
from ovman.workflow.parameter import StageSettings


def traced(runs: Sequence[tuple[Score, StageSettings]], episode: Episode) -> Iterator[Drive]:
    """The paths of runs of an episode that have a trace. SimulatorError if the simulator refuses."""
    by_body: dict[str, list[tuple[Score, StageSettings]]] = {}
    for run, settings in runs:
        if run.trace is not None:
            by_body.setdefault(settings.arm.embodiment, []).append((run, settings))
    for alike in by_body.values():
        with open_session(episode, alike[0][1].arm, alike[0][1]) as session:
            for run, settings in alike:
                again = Run(episode, settings.arm, run.seed, settings)
                yield Drive(run, session.with_restarts(partial(_poses, session, again, run.trace or "")))


def runs_of_evaluation(directory: Path, episode: Episode, settings: Settings) -> list[tuple[Score, StageSettings]]:
    """The runs of an episode that `ovman eval` left in a folder. EntryError or RecordError, in one line."""
    of = replay_settings(settings, read_manifest(directory))
    return [(run, of) for _, run in read_runs(runs_path(directory)) if run.episode == episode.id]


def _poses(session: Session, run: Run, trace: str) -> list[Pose]:
    env = open_env(session, run)
    poses = [_pose(session)]
    for letter in trace:
        _, done = env.step(ACTIONS[letter])
        if letter not in ENDS:
            poses.append(_pose(session))
        if done:
            break
    return poses


ENDS = frozenset(letter for action, letter in LETTERS.items() if action.value in ("Stop", "Abstain"))
"""Letters of actions that move nothing."""


def _pose(session: Session) -> Pose:
    pose = session.pose
    return pose.x, pose.z, pose.yaw_deg
