"""Stage `runs`: judges the measured executions (Eq. 4 and 5). Pure."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.analysis.outcomes import OWN_SUCCESS
from ovman.models.record import read_records
from ovman.models.settings import Arm, Settings
from ovman.models.settings.benchmark import Success
from ovman.sim.recorded import MEASURED, any_instance, judged
from ovman.task import Relation, spl

FIELDS = ("schema", "episode", "arm", "seed", "outcome", *MEASURED)


def judge(execution: Mapping[str, Any], episode: Mapping[str, Any], constants: Success, own_task: bool = False) -> dict[str, Any]:
    """An "ovman-run/1" record: the execution with its success and SPL.

    own_task: whether the agent has a task of its own, to reach any instance of the category; the verdict on that is added.
    """
    success = judged(execution, Relation(episode["relation"]), constants)
    score = spl(success, episode["shortest_path_m"], execution["path_length_m"])
    judged_on = {"success": success, "spl": round(score, 6)}
    own = {OWN_SUCCESS: any_instance(execution, constants)} if own_task else {}
    return {field: execution[field] for field in FIELDS} | judged_on | own


def cut(execution: Mapping[str, Any], arm: Arm) -> Mapping[str, Any]:
    """The run of another arm as that of an arm which has a smaller budget of actions, and else does the same.

    Raises ValueError where the run went on and its path length up to there was not written down.
    """
    if arm.cut_from is None or arm.budget is None:
        return execution
    kept = {**execution, "arm": arm.name}
    ended = execution["outcome"] in ("stalled", "budget") and execution["actions"] == arm.budget
    if execution["actions"] < arm.budget or ended:
        return kept
    travelled = execution.get("path_at_m", {}).get(str(arm.budget))
    if travelled is None:
        raise ValueError(f"{execution['episode']}: {arm.cut_from} was not run for {arm.name}; make its executions again")
    return kept | dict.fromkeys(MEASURED) | {"outcome": "budget", "path_length_m": travelled, "actions": arm.budget}


def run(
    executions_files: Sequence[Path], episodes_file: Path, constants: Settings, outputs: Sequence[Path], arm: Arm | None = None
) -> None:
    """Judge each file of executions into the output of the same position; arm: whose they are, if they may have to be cut."""
    episodes = {e["id"]: e for e in read_records(episodes_file)}
    for source, output in zip(executions_files, outputs, strict=True):
        executions = [x if arm is None else cut(x, arm) for x in read_records(source)]
        own_task = arm is not None and arm.any_instance
        records = [judge(x, episodes[x["episode"]], constants.success, own_task) for x in executions]
        Path(output).parent.mkdir(parents=True, exist_ok=True)
        Path(output).write_text("".join(json.dumps(r, separators=(",", ":")) + "\n" for r in records))
