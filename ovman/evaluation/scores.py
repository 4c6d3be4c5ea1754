"""Stage `scores`: judges the measured rollouts (Eq. 4 and 5) by the constants of their episodes. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.evaluation.scoring import any_instance, judged
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import NOWHERE, Rollout, Score, Travelled
from ovman.settings import Arm
from ovman.task import spl


def score(rollout: Rollout, episode: Episode, own_task: bool = False) -> Score:
    """A rollout with its success and SPL.

    own_task: whether the agent's own task is to reach any instance of the category; the verdict on that is added.
    """
    constants = episode.protocol.success
    success = judged(rollout, episode.relation, constants)
    return Score(
        **{name: getattr(rollout, name) for name in _SCORED},
        success=success,
        spl=round(spl(success, episode.shortest_path_m, rollout.path_length_m), 6),
        own_success=any_instance(rollout, constants) if own_task else None,
    )


_SCORED = ("episode", "arm", "seed", "outcome", *Travelled.model_fields, "trace")
"""Fields of a rollout that its score repeats."""


def cut(rollout: Rollout, arm: Arm) -> Rollout:
    """The run of another arm as that of an arm which has a smaller budget of actions, and else does the same.

    Raises ValueError where the run went on and its path length up to there was not recorded.
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


def run(rollout_files: Sequence[Path], episodes_file: Path, outputs: Sequence[Path], arm: Arm | None = None) -> None:
    """Judge each file of rollouts into the output of the same position, or all of them into the one output.

    arm: whose they are, if they may have to be cut.
    """
    episodes = {episode.id: episode for episode in Episode.load(episodes_file)}
    parts = [list(rollout_files)] if len(outputs) == 1 else [[file] for file in rollout_files]
    for sources, output in zip(parts, outputs, strict=True):
        rollouts = [run if arm is None else cut(run, arm) for source in sources for run in Rollout.read(source)]
        own_task = arm is not None and arm.any_instance
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(lines(score(rollout, episodes[rollout.episode], own_task) for rollout in rollouts), encoding="utf-8")
