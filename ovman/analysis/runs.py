"""Stage `runs`: judges the measured executions (Eq. 4 and 5). Pure."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.constants import task_constants
from ovman.sim.recorded import MEASURED, judged
from ovman.task import Relation, SuccessConstants, spl
from ovman.task.record import read_records

FIELDS = ("schema", "episode", "arm", "seed", "outcome", *MEASURED)


def judge(execution: Mapping[str, Any], episode: Mapping[str, Any], constants: SuccessConstants) -> dict[str, Any]:
    """An "ovman-run/1" record: the execution with its success and SPL."""
    success = judged(execution, Relation(episode["relation"]), constants)
    score = spl(success, episode["shortest_path_m"], execution["path_length_m"])
    return {field: execution[field] for field in FIELDS} | {"success": success, "spl": round(score, 6)}


def run(executions_files: Sequence[Path], episodes_file: Path, constants: Any, outputs: Sequence[Path]) -> None:
    """Judge each file of executions into the output of the same position."""
    task = task_constants(constants)
    episodes = {e["id"]: e for e in read_records(episodes_file)}
    for source, output in zip(executions_files, outputs, strict=True):
        records = [judge(x, episodes[x["episode"]], task) for x in read_records(source)]
        Path(output).parent.mkdir(parents=True, exist_ok=True)
        Path(output).write_text("".join(json.dumps(r, separators=(",", ":")) + "\n" for r in records))
