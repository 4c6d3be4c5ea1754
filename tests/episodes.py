"""The released episodes, their sightings, and maps that are true to what the tours recorded."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.evaluation.privileged_grounding import recorded_positions
from ovman.language import noun
from ovman.models.episode import Episode
from ovman.models.relation import Relation
from ovman.models.sighting import Sighting, Sightings
from ovman.models.world_state import Instance, WorldState
from ovman.perception.clusters import Cluster

DATA = Path(__file__).parents[1] / "data" / "ovman-embedded-v1"
EPISODES, SIGHTINGS = DATA / "episodes" / "main.jsonl", DATA / "episodes" / "sightings.jsonl"


@cache
def released() -> tuple[Episode, ...]:
    """All released episodes in their order."""
    return tuple(Episode.load(EPISODES))


@cache
def sightings() -> dict[str, Sightings]:
    """By episode."""
    return {record.episode: record for record in Sightings.read(SIGHTINGS)}


def of_scene(scene: str) -> list[Episode]:
    """The released episodes of a scene."""
    return [episode for episode in released() if episode.scene == scene]


def true_map(seen: tuple[Sighting, ...]) -> tuple[Cluster, ...]:
    """One cluster for each place where an instance was recorded, and something else far away."""
    places = np.unique(recorded_positions(seen, 300), axis=0)
    feature, other = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    views = np.array([0])
    return (
        *(Cluster(place, feature, place[None], views) for place in places),
        Cluster(np.array([50.0, 50.0]), other, np.array([[50.0, 50.0]]), views),
    )


def made(relation: Relation, number: int, scene: str, category: str, answer: tuple[float, float], **fields: Any) -> Episode:
    """An episode of a scene that is not there: of the instance "a" of a category, at the place that answers, in both visits."""
    pattern = next(episode for episode in released() if episode.relation is relation)
    distractor = "b" if relation is Relation.STABLE else None
    world = WorldState((Instance("a", category, *answer),))
    return pattern.model_copy(
        update={
            "id": f"{scene}/{relation}/{number:04d}",
            "scene": scene,
            "category": category,
            "noun": noun(category),
            "target": "a",
            "distractor": distractor,
            "changes": (pattern.changes[0].model_copy(update={"instance": distractor or "a"}),),
            "answer": answer,
            "instances_in_category": 2,
            "world_1": world,
            "world_2": world,
        }
        | fields
    )
