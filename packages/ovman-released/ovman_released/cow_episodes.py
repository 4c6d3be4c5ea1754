"""Episodes as CoW's released runner takes them. Of the truth the runner gets the id of the target alone, which it needs for a
success of its own that is not read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ovman.language import noun
from ovman.records.episode import Episode

FEET_M = 0.9
"""Height of the agent's position above its feet, metres; the simulator knows the height of a floor plan's own floor."""


def runner_name(episode: Episode) -> str:
    """The episode's id in the released runner, which names a file after it and counts categories by its fourth part."""
    scene, relation, number = episode.id.split("/")
    return f"{scene}_physics_{relation}_{episode.category}_{number}"


def exported(episode: Episode) -> dict[str, Any]:
    """The dictionary that the released runner is given for an episode; metres, degrees."""
    spawn = {"x": episode.spawn.x, "y": FEET_M, "z": episode.spawn.z}
    goal = {"x": episode.nearest_navigable[0], "y": FEET_M, "z": episode.nearest_navigable[1]}
    return {
        "id": runner_name(episode),
        "scene": episode.scene,
        "object_type": episode.category,
        "object_id": episode.target,
        "initial_position": spawn,
        "initial_orientation": episode.spawn.yaw_deg,
        "initial_horizon": 0,
        # Copied through to a path-length score that is not read.
        "shortest_path": [spawn, goal],
        "shortest_path_length": episode.shortest_path_m,
    }


def vocabulary(categories: Sequence[str], released: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """The categories that the episodes ask for, sorted, and the name that each has in the released prompt.

    released: the names that the released code has for categories of its own; they stay as they are.
    """
    kinds = sorted(set(categories))
    return kinds, [released.get(kind, noun(kind)) for kind in kinds]
