"""Episodes as CoW's released runner takes them, and what the evaluator keeps of each: the truth does not go into the former
beyond the id of the target, which the runner needs for a success of its own that nobody reads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ovman.evaluation.assignment import Assignment
from ovman.language.noun import noun
from ovman.sim.change import Alteration
from ovman.sim.session import AgentPose
from ovman.task import Relation

FEET_M = 0.9
"""The agent's position is so far above its feet; the height of a floor plan's own floor is the simulator's to say."""


@dataclass(frozen=True)
class Hidden(Assignment):
    """What the evaluator knows of an episode while the released runner is in it.

    episode: its id; shortest_m: L* of Eq. 5.
    """

    episode: str
    scene: str
    shortest_m: float

    @staticmethod
    def of(trial: Mapping[str, Any]) -> Hidden:
        """From a measured trial."""
        candidate = trial["candidate"]
        shortest_m = trial["measured"]["shortest_path_m"]
        return Hidden(**vars(Assignment.of(trial)), episode=candidate["id"], scene=candidate["scene"], shortest_m=shortest_m)

    @staticmethod
    def from_json(record: Mapping[str, Any]) -> Hidden:
        given = dict(record)
        given["relation"], given["spawn"] = Relation(given["relation"]), AgentPose(**given["spawn"])
        given["second"] = tuple(Alteration.from_json(a) for a in given["second"])
        return Hidden(**given | {name: tuple(given[name]) for name in ("answer", "navigable")})

    def to_json(self) -> dict[str, Any]:
        second = [alteration.to_json() for alteration in self.second]
        return asdict(self) | {"relation": str(self.relation), "spawn": asdict(self.spawn), "second": second}

    @property
    def name(self) -> str:
        """The episode's id in the released runner, which names a file after it and counts categories by its fourth part."""
        scene, relation, number = self.episode.split("/")
        return f"{scene}_physics_{relation}_{self.category}_{number}"


def exported(hidden: Hidden) -> dict[str, Any]:
    """The dictionary that the released runner is given for an episode."""
    spawn = {"x": hidden.spawn.x, "y": FEET_M, "z": hidden.spawn.z}
    goal = {"x": hidden.navigable[0], "y": FEET_M, "z": hidden.navigable[1]}
    return {
        "id": hidden.name,
        "scene": hidden.scene,
        "object_type": hidden.category,
        "object_id": hidden.target,
        "initial_position": spawn,
        "initial_orientation": hidden.spawn.yaw_deg,
        "initial_horizon": 0,
        # Copied through to a path-length score that is not read.
        "shortest_path": [spawn, goal],
        "shortest_path_length": hidden.shortest_m,
    }


def vocabulary(categories: Sequence[str], released: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """The categories that are asked for, sorted, and the name that each has in the released prompt.

    released: the names that the released code has for categories of its own, which stay as they are.
    """
    kinds = sorted(set(categories))
    return kinds, [released.get(kind, noun(kind)) for kind in kinds]
