"""World states: which instances are present in a visit, and where."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, TypeAdapter

from ovman.records.geometry import Point


@dataclass(frozen=True, slots=True)
class Instance:
    """An instance present in a visit.

    x, z: floor-plane position in metres, the last one where it moved during the visit; track: ((x, z), ...) positions within
    the visit in the order they were seen, empty where only one position is known. Raises ValueError where the track ends
    elsewhere than (x, z).
    """

    id: str
    category: str
    x: float
    z: float
    track: tuple[Point, ...] = ()

    def __post_init__(self) -> None:
        if self.track and tuple(self.track[-1]) != (self.x, self.z):
            raise ValueError(f"instance {self.id}: its track ends at {tuple(self.track[-1])}, its position is {(self.x, self.z)}")

    @staticmethod
    def tracked(id: str, category: str, track: tuple[Point, ...]) -> Instance:
        """The instance that was seen at the positions of `track`, at least one; its position is the last."""
        x, z = track[-1]
        return Instance(id, category, x, z, track)

    @property
    def position(self) -> Point:
        """Floor-plane position in metres."""
        return self.x, self.z

    @property
    def extent_m(self) -> float:
        """Largest distance between two positions within the visit, metres; 0 without a track."""
        return max((math.dist(a, b) for a, b in combinations(self.track, 2)), default=0.0)


@dataclass(frozen=True)
class WorldState:
    """W_v: the instances present in visit v. Raises ValueError where an id occurs twice."""

    instances: tuple[Instance, ...]

    def __post_init__(self) -> None:
        if len(self._by_id) != len(self.instances):
            ids = [instance.id for instance in self.instances]
            twice = next(k for k in ids if ids.count(k) > 1)
            raise ValueError(f"instance {twice} is in the world state twice")

    @cached_property
    def _by_id(self) -> dict[str, Instance]:
        return {instance.id: instance for instance in self.instances}

    @property
    def ids(self) -> frozenset[str]:
        """K_v."""
        return frozenset(self._by_id)

    def __contains__(self, instance_id: object) -> bool:
        return instance_id in self._by_id

    def __iter__(self) -> Iterator[Instance]:
        return iter(self.instances)

    def __len__(self) -> int:
        return len(self.instances)

    def __getitem__(self, instance_id: str) -> Instance:
        """The instance with this id; KeyError where it is absent."""
        if instance_id not in self._by_id:
            raise KeyError(f"instance {instance_id} is absent from this visit")
        return self._by_id[instance_id]

    def category(self, category: str) -> tuple[Instance, ...]:
        """The instances of a category, in the order of the state."""
        return tuple(instance for instance in self.instances if instance.category == category)


def displacement_m(world_1: WorldState, world_2: WorldState, instance_id: str) -> float | None:
    """Delta_k, metres on the floor plane from the position in visit 1 to that in visit 2; None unless present in both visits."""
    if instance_id not in world_1 or instance_id not in world_2:
        return None
    return math.dist(world_1[instance_id].position, world_2[instance_id].position)


@cache
def _instances() -> TypeAdapter[tuple[Instance, ...]]:
    """Reads instances; made at the first use, so that a job that reads none starts without it."""
    return TypeAdapter(tuple[Instance, ...])


def _world(value: Any) -> WorldState:
    return value if isinstance(value, WorldState) else WorldState(_instances().validate_python(value))


def instance_json(instance: Instance) -> dict[str, Any]:
    """An instance as files have it: {"id", "category", "x", "z"} and, where it has one, "track"."""
    made: dict[str, Any] = {"id": instance.id, "category": instance.category, "x": float(instance.x), "z": float(instance.z)}
    if instance.track:
        made["track"] = [{"x": float(x), "z": float(z)} for x, z in instance.track]
    return made


RecordedWorld = Annotated[
    WorldState, PlainValidator(_world), PlainSerializer(lambda world: [instance_json(instance) for instance in world])
]
"""A world state as a field of a record: a list of instances in files."""
