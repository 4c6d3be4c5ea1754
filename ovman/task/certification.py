"""The oracle's runs that certify an episode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ovman.task.pose import Spawn
from ovman.task.record import Node
from ovman.task.success import Measurement


@dataclass(frozen=True, slots=True)
class CertificationRun:
    """One run of the oracle: run 0 is the feasibility run, the others certify. Metres, degrees, pixels, numbers of actions.

    stop: where the oracle stopped, None where it did not.
    """

    run: int
    seed: int
    success: bool
    stop: Spawn | None
    measurement: Measurement
    path_length_m: float
    actions: int

    @staticmethod
    def read(node: Node) -> CertificationRun:
        return CertificationRun(
            run=node["run"].integer(),
            seed=node["seed"].integer(),
            success=node["success"].boolean(),
            stop=node["stop"].optional(Spawn.read),
            measurement=Measurement(
                node["box_distance_m"].optional(Node.length),
                node["answer_distance_m"].length(),
                node["navigable_distance_m"].length(),
                node["visible_px"].optional(_masks),
            ),
            path_length_m=node["path_length_m"].length(),
            actions=node["actions"].integer(),
        )

    def to_json(self) -> dict[str, Any]:
        box_distance_m, masks = self.measurement.box_distance_m, self.measurement.visible_px
        return {
            "run": self.run,
            "seed": self.seed,
            "success": self.success,
            "stop": None if self.stop is None else self.stop.to_json(),
            "box_distance_m": None if box_distance_m is None else float(box_distance_m),
            "answer_distance_m": float(self.measurement.answer_distance_m),
            "navigable_distance_m": float(self.measurement.navigable_distance_m),
            "visible_px": None if masks is None else {str(pitch): px for pitch, px in masks.items()},
            "path_length_m": float(self.path_length_m),
            "actions": self.actions,
        }


def _masks(node: Node) -> dict[int, int]:
    return {_pitch(name, px): px.integer() for name, px in node.items()}


def _pitch(name: str, node: Node) -> int:
    if not name.removeprefix("-").isdecimal():
        raise node.fail(f"the pitch {name!r} is no number of degrees", "write whole degrees")
    return int(name)
