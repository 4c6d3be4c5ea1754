"""What CoW's released runner wrote of an episode, and what was measured at its stop, as an "ovman-run/1" record.

The runner's own success is not read: it is judged as every arm is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.models.record import Node
from ovman.sim.recorded import MEASURED
from ovman_released.cow_controller import ARM, STOP
from ovman_released.cow_episodes import Hidden

SCHEMA = "ovman-run/1"
SAME_M = 1e-3
"""How far the runner's last pose may be from where the stop was measured."""


@dataclass(frozen=True)
class Walk:
    """A run of the released agent: its floor-plane positions (x, z) in metres from the start on, one more than actions; whether
    the last action is Stop."""

    positions: tuple[tuple[float, float], ...]
    stopped: bool

    @property
    def path_length_m(self) -> float:
        return math.fsum(math.dist(a, b) for a, b in zip(self.positions, self.positions[1:], strict=False))

    @property
    def actions(self) -> int:
        """Actions before the stop, which is none."""
        return len(self.positions) - 1 - self.stopped

    @staticmethod
    def read(path: Path) -> Walk:
        """From the runner's file. RecordError in one line where it is not what the released runner writes."""
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise Node(None, str(path)).fail(f"cannot be read ({error})", "run the released system again") from None
        metrics = Node(record, str(path))["episode_metrics"]
        trajectory = list(metrics["trajectory"].elements())
        actions = [node["action"].text() for node in metrics["actions_taken"].elements()]
        if len(trajectory) != len(actions) + 1:
            complaint = f"{len(trajectory)} poses for {len(actions)} actions"
            raise metrics["trajectory"].fail(complaint, "there must be one pose more; run the released system again")
        positions = tuple((pose["x"].number(), pose["z"].number()) for pose in trajectory)
        return Walk(positions, bool(actions) and actions[-1] == STOP)


def read_verdicts(path: Path) -> dict[str, Mapping[str, Any]]:
    """What was measured where the runner let go of each episode, by the episode's name there."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return {record["name"]: record for record in map(json.loads, lines)}


def imported(hidden: Hidden, seed: int, walk: Walk, verdict: Mapping[str, Any]) -> dict[str, Any]:
    """The measured part of an "ovman-run/1" record. `instances`: of every instance of the category, for CoW's own task.

    ValueError where walk and verdict are of different runs.
    """
    measured: dict[str, Any] = dict.fromkeys(MEASURED)
    if walk.stopped != verdict["stopped"]:
        raise ValueError(
            f"{hidden.episode}: the runner and the test at the stop do not agree on whether it stopped; run it again"
        )
    if walk.stopped:
        stop = verdict["stop"]["x"], verdict["stop"]["z"]
        if math.dist(stop, walk.positions[-1]) > SAME_M:
            raise ValueError(f"{hidden.episode}: measured at {stop}, stopped at {walk.positions[-1]}; run it again")
        measured |= {name: verdict[name] for name in MEASURED if name in verdict}
    record = {"schema": SCHEMA, "episode": hidden.episode, "arm": ARM, "seed": seed}
    record |= {"outcome": "stopped" if walk.stopped else "budget"} | measured
    record |= {"path_length_m": round(walk.path_length_m, 4), "actions": walk.actions}
    return record | ({"instances": verdict["instances"]} if "instances" in verdict else {})


def collected(results: Path, verdicts: Path, hidden: tuple[Hidden, ...], seed: int) -> list[dict[str, Any]]:
    """The records of all episodes in their order. RecordError or ValueError in one line where one is missing or broken."""
    measured = read_verdicts(verdicts)
    records = []
    for episode in hidden:
        if episode.name not in measured:
            raise ValueError(f"{episode.episode}: the released runner left no verdict in {verdicts}; run it again")
        walk = Walk.read(results / f"{episode.name}.json")
        records.append(imported(episode, seed, walk, measured[episode.name]))
    return records
