"""The terms of the task: relations, queries, reasons of rejection, measurements at a stop, world states."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, cached_property
from itertools import combinations
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, TypeAdapter

from ovman.records.geometry import Point


class Relation(StrEnum):
    """A relation between an instance and two visits. It selects the referent of a query and the position that answers it."""

    MOVED = "moved"
    FORMER = "former"
    MOVING = "moving"
    STABLE = "stable"
    APPEARED = "appeared"
    REMOVED = "removed"

    @property
    def past(self) -> bool:
        """Whether the answer is a position of visit 1, a place where nothing is any more (R_past)."""
        return self in (Relation.FORMER, Relation.REMOVED)

    @property
    def current(self) -> bool:
        """Whether the answer is a position of visit 2 (R_cur)."""
        return not self.past


@dataclass(frozen=True, slots=True)
class Query:
    """q = (c, rho): a category and a change relation."""

    category: str
    relation: Relation


class RejectionStage(StrEnum):
    """The part of Algorithm 1 that rejects, in its order."""

    DRAW = "draw"  # lines 1 and 3: nothing to choose from
    PLACEMENT = "placement"  # line 3: the scripted change
    GEOMETRY = "geometry"  # line 4: reachable, mobile, visible
    OBSERVATION = "observation"  # lines 6 and 7: what the tours recorded
    CERTIFICATION = "certification"  # lines 8 and 9: the oracle's runs
    RELEASE = "release"  # lines 10 to 12: what is certified, but not independent of what is released
    SIMULATOR = "simulator"  # no verdict of the benchmark: the simulator failed


DRAWN, CERTIFIED, RELEASED = "drawn", "certified", "released"
"""Stages of the audit in addition to those of rejections."""


class Rejection(StrEnum):
    """Reasons in the order in which they are checked; the first one counts.

    stage: the part of Algorithm 1 that rejects for this reason.
    """

    stage: RejectionStage

    def __new__(cls, value: str, stage: RejectionStage) -> Rejection:
        """Return a reason. Its value is the text alone."""
        made = str.__new__(cls, value)
        made._value_, made.stage = value, stage
        return made

    NO_PLACEMENT = "no_placement", RejectionStage.DRAW
    CANNOT_MOVE = "cannot_move", RejectionStage.DRAW
    NO_SPAWN = "no_spawn", RejectionStage.DRAW
    PLACEMENT_REFUSED = "placement_refused", RejectionStage.PLACEMENT
    DISPLACEMENT_BELOW_MINIMUM = "displacement_below_minimum", RejectionStage.PLACEMENT
    SPAWN_TOO_CLOSE = "spawn_too_close", RejectionStage.PLACEMENT
    SPAWN_AT_ANSWER = "spawn_at_answer", RejectionStage.GEOMETRY
    SPAWN_IMMOBILE = "spawn_immobile", RejectionStage.GEOMETRY
    ANSWER_UNREACHABLE = "answer_unreachable", RejectionStage.GEOMETRY
    ANSWER_NOT_VISIBLE = "answer_not_visible", RejectionStage.GEOMETRY
    RIVAL_NEAR = "rival_near", RejectionStage.GEOMETRY
    CHANGED_INSTANCE_NOT_RECORDED = "changed_instance_not_recorded", RejectionStage.OBSERVATION
    FEW_RECORDED = "few_recorded", RejectionStage.OBSERVATION
    MOTION_NOT_RECORDED = "motion_not_recorded", RejectionStage.OBSERVATION
    REFERENT_ABSENT = "referent_absent", RejectionStage.OBSERVATION
    REFERENT_AMBIGUOUS = "referent_ambiguous", RejectionStage.OBSERVATION
    REFERENT_NOT_TARGET = "referent_not_target", RejectionStage.OBSERVATION
    BYSTANDER_MOVED = "bystander_moved", RejectionStage.OBSERVATION
    DRIFTED = "drifted", RejectionStage.OBSERVATION
    FEASIBILITY_FAILED = "feasibility_failed", RejectionStage.CERTIFICATION
    CERTIFICATION_FAILED = "certification_failed", RejectionStage.CERTIFICATION
    NOT_CROSSED = "not_crossed", RejectionStage.RELEASE
    SIMULATOR_ERROR = "simulator_error", RejectionStage.SIMULATOR


@dataclass(frozen=True, slots=True)
class Measurement:
    """Measurements where an agent stops, metres and pixels.

    box_distance_m: from the stop p to the target's axis-aligned box; answer_distance_m: |p - a|; navigable_distance_m: |p -
    nu(a)|, to the navigable cell of the spawn's component that is nearest to the answer; visible_px: size of the target's mask
    at each pitch of the look-down sweep, keyed by the pitch in degrees. Box and masks are None where no object is left to
    measure them on. rival_distance_m: from p to the nearest rival, None where success is not exclusive. Raises ValueError for a
    negative distance or one that is not a number.
    """

    box_distance_m: float | None
    answer_distance_m: float
    navigable_distance_m: float
    visible_px: Mapping[int, int] | None
    rival_distance_m: float | None = None

    def __post_init__(self) -> None:
        for name in ("box_distance_m", "answer_distance_m", "navigable_distance_m", "rival_distance_m"):
            value = getattr(self, name)
            if value is not None and not value >= 0.0:
                raise ValueError(f"{name} is {value}: a distance is at least 0")


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
        """Return the instance that was seen at the positions of `track`, at least one; its position is the last."""
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
        """Return the instance with this id; KeyError where it is absent."""
        if instance_id not in self._by_id:
            raise KeyError(f"instance {instance_id} is absent from this visit")
        return self._by_id[instance_id]

    def with_tracks(self, paths: Mapping[str, tuple[Point, ...]]) -> WorldState:
        """Return the state in which these paths, by id, are the tracks of instances that have none."""
        found = (
            Instance.tracked(one.id, one.category, paths[one.id]) if one.id in paths and not one.track else one for one in self
        )
        return WorldState(tuple(found))

    def category(self, category: str) -> tuple[Instance, ...]:
        """Return the instances of a category, in the order of the state."""
        return tuple(instance for instance in self.instances if instance.category == category)


def displacement_m(world_1: WorldState, world_2: WorldState, instance_id: str) -> float | None:
    """Delta_k, metres on the floor plane from the position in visit 1 to that in visit 2; None unless present in both visits."""
    if instance_id not in world_1 or instance_id not in world_2:
        return None
    return math.dist(world_1[instance_id].position, world_2[instance_id].position)


Places = Mapping[str, Point | None]
"""Floor-plane positions in metres by instance, None for one that is absent."""


def rivals(
    query: Query,
    target: str,
    world_1: WorldState,
    world_2: WorldState,
    changed: tuple[Places, Places],
    stable: Mapping[str, Point] = {},
    now: Mapping[str, Point] = {},
) -> tuple[Point, ...]:
    """Return the sorted places that are wrong answers to a query about `target`.

    They are where every other instance of the category and every other changed instance stood in visit 1 and stands in visit 2,
    for MOVED and FORMER where the target itself is in the other visit, and the places of `stable`. The answer to a query about
    one place is therefore a rival of each query of the same world pair about another.

    changed: of the instances that change, the positions at the end of each visit. stable: of the instances that STABLE queries of
    the same world pair mean. now: of movers, their present places, which replace those of visit 2.
    """
    both: list[dict[str, Point]] = []
    for world, places in zip((world_1, world_2), changed, strict=True):
        of_category = {instance.id: instance.position for instance in world.category(query.category)}
        both.append(of_category | {k: place for k, place in places.items() if place is not None})
    before, after = both
    after |= {**stable, **now}
    if query.relation is not Relation.MOVED:
        before.pop(target, None)
    if query.relation is not Relation.FORMER:
        after.pop(target, None)
    return tuple(sorted({*before.values(), *after.values()}))


@cache
def _instances() -> TypeAdapter[tuple[Instance, ...]]:
    """Return the validator of instances, built at the first use: a job that reads none starts sooner."""
    return TypeAdapter(tuple[Instance, ...])


def _world(value: Any) -> WorldState:
    return value if isinstance(value, WorldState) else WorldState(_instances().validate_python(value))


def instance_json(instance: Instance) -> dict[str, Any]:
    """Return an instance as files have it: {"id", "category", "x", "z"} and the "track", if it has one."""
    made: dict[str, Any] = {"id": instance.id, "category": instance.category, "x": float(instance.x), "z": float(instance.z)}
    if instance.track:
        made["track"] = [{"x": float(x), "z": float(z)} for x, z in instance.track]
    return made


RecordedWorld = Annotated[
    WorldState, PlainValidator(_world), PlainSerializer(lambda world: [instance_json(instance) for instance in world])
]
"""A world state as a field of a record: a list of instances in files."""
