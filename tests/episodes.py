"""The released episodes and their sightings, maps that are true to the tours, and episodes with other content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.evaluation.true_grounding import recorded_positions
from ovman.language import noun
from ovman.perception.clusters import Cluster
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.records.visit import Sighting, Sightings

ROOT = Path(__file__).parents[1]
DATA = ROOT / "data" / "ovman-embedded-v6"
EPISODES, SIGHTINGS = DATA / "episodes" / "main.jsonl", DATA / "sightings" / "main.jsonl"
TARGET, OTHER = "a", "b"


@cache
def released() -> tuple[Episode, ...]:
    """All released episodes in their order."""
    return tuple(Episode.load(EPISODES))


@cache
def scene_record(name: str) -> Scene:
    """Return the released record of a floor plan."""
    return next(one for split in ("main", "dev") for one in Scene.read(DATA / "scenes" / f"{split}.jsonl") if one.scene == name)


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


def episode_record(
    relation: str,
    number: int = 0,
    *,
    answer: tuple[float, float] = (1.0, 0.0),
    world: Sequence[Mapping[str, Any]] | None = None,
    visits: Mapping[str, str] | None = None,
    scene: str = "FloorPlan1",
    category: str = "Chair",
) -> dict[str, Any]:
    """A whole record: a released episode of the relation with another id, answer and worlds. TARGET is the queried instance."""
    record = next(one for one in released() if one.relation == relation).to_json()
    point = {"x": answer[0], "z": answer[1]}
    here = [{"id": TARGET, "category": category, **point}] if world is None else list(world)
    distractor = OTHER if record["distractor"] is not None else None
    return record | {
        "id": f"{scene}/{relation}/{number:04d}",
        "scene": scene,
        "category": category,
        "noun": noun(category),
        "instances_in_category": 2,
        "answer": point,
        "target": TARGET,
        "distractor": distractor,
        "changes": [{**change, "instance": distractor or TARGET, "category": category} for change in record["changes"][:1]],
        "movers": [{**mover, "instance": TARGET} for mover in record["movers"]],
        "visits": visits or record["visits"],
        "world_1": here,
        "world_2": here,
    }
