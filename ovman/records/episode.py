"""An episode, "ovman-episode/4": everything needed to set it up, tour, query, run and score it.

What only diagnostic arms may know is apart, in `ovman.records.visit.Sightings`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from ovman.records.geometry import Point, Spawn, floor_point
from ovman.records.record import InstanceId, Length, Name, Record, RecordError, Text, optional, read_lines, unless_default
from ovman.records.scene import Alteration, Change, MoverStart
from ovman.records.task import Query, RecordedWorld, Relation, WorldState, rivals
from ovman.records.tour import Tour
from ovman.records.trial import CertificationRun, ReachableBox
from ovman.records.visit import VisitPair
from ovman.settings import Settings
from ovman.settings.benchmark import Camera, Mover, Primitives, Success
from ovman.settings.splits import Rules

SCHEMA = "ovman-episode/4"


class Protocol(Record):
    """The constants of config.yaml that an episode is toured, run and judged with."""

    camera: Camera
    primitives: Primitives
    mover: Mover
    success: Success


class Provenance(Record):
    """Origin of an episode. seed: root of every random number; trial: digest of the trial that it was released from."""

    seed: int
    trial: Text


class Episode(Record):
    """One released episode. Floor-plane coordinates (x, z) in metres, world frame.

    pair: the world pair that it belongs to, None if it stands alone; episodes of a pair have their changes, tours and spawn in
    common; changes: what differs between the visits and how the simulator makes it, of the queried category (`scripted`) and of
    others; tours: of the visits; visits: names of the recorded tours; movers: their states where a run begins; spawn: where a
    run begins; answer: Eq. 3 at the end of visit 2; nearest_navigable: nu(answer); shortest_path_m: L* of Eq. 5; reachable_box:
    around what can be reached in visit 2; world_1, world_2: the present instances of the category at the end of each visit;
    drift_m: how far each changed instance was from its placement; stable: places of the unchanged instances that STABLE queries
    of the same world pair mean; rules: of the split's runs. Files leave out both where they are the paper's. Raises RecordError,
    one line, for a record that contradicts itself.
    """

    schema_id: Literal["ovman-episode/4"] = Field("ovman-episode/4", alias="schema")
    id: Text
    pair: Text | None = optional()
    split: Name
    backend: Literal["embedded", "thor"]
    scene: Name
    relation: Relation
    category: Text
    noun: Text
    sentence: Text
    target: InstanceId
    distractor: InstanceId | None
    changes: tuple[Change, ...]
    tours: VisitPair[Tour]
    visits: VisitPair[Name]
    movers: tuple[MoverStart, ...]
    spawn: Spawn
    answer: Point
    nearest_navigable: Point
    shortest_path_m: Length
    reachable_box: ReachableBox
    instances_in_category: int
    world_1: RecordedWorld
    world_2: RecordedWorld
    drift_m: Mapping[str, Length]
    certification: tuple[CertificationRun, ...]
    protocol: Protocol
    stable: Mapping[InstanceId, Point] = unless_default({})
    rules: Rules = unless_default(Rules())
    provenance: Provenance

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        scene, _, rest = self.id.partition("/")
        relation, _, number = rest.partition("/")
        if (scene, relation) != (self.scene, self.relation) or not number.removeprefix(f"{self.split}-").isdigit():
            raise ValueError(f"id is {self.id!r}; write {self.scene}/{self.relation}/ and a number")
        if self.instances_in_category < 2:
            raise ValueError(f"instances_in_category is {self.instances_in_category}; a query needs a category with at least 2")
        if (self.distractor is not None) != (self.relation is Relation.STABLE):
            raise ValueError(f"distractor is {self.distractor!r}; STABLE has one and no other relation does")
        moving = [mover.instance for mover in self.movers]
        if (
            self.relation is Relation.MOVING
            and not moving
            or moving
            and self.relation is not Relation.MOVING
            and self.pair is None
        ):
            raise ValueError("movers: MOVING has some, and so have other relations of a world pair alone")
        if sorted(moving) != sorted(change.instance for change in self.changes if change.kind == "motion"):
            raise ValueError(f"movers are {moving}; they are the instances of the changes of kind motion")
        if self.relation is Relation.MOVING and self.target not in moving:
            raise ValueError(f"movers are {moving}; the target {self.target!r} moves")
        visit, world = ("world_1", self.world_1) if self.relation.past else ("world_2", self.world_2)
        if self.target not in world or world[self.target].category != self.category:
            raise ValueError(f"target {self.target!r} is no {self.category} of {visit}, which {self.relation} answers from")
        cause = self.distractor if self.distractor is not None else self.target
        if cause not in {change.instance for change in self.scripted}:
            raise ValueError(f"changes do not hold {cause!r}, whose change defines the episode")
        return self

    @classmethod
    def load(cls, path: Path, scene: str | None = None) -> list[Self]:
        """Return the episodes of a JSONL file, or those of one scene. Raises RecordError, also for an id that is there twice."""
        episodes: dict[str, Self] = {}
        for place, text in read_lines(path):
            episode = cls.parse(text, place)
            if episode.id in episodes:
                raise RecordError(f"{place}: id: {episode.id} is in the file already; remove one of the two")
            episodes[episode.id] = episode
        return [episode for episode in episodes.values() if scene in (None, episode.scene)]

    @property
    def query(self) -> Query:
        """Category and relation that are asked for."""
        return Query(self.category, self.relation)

    @property
    def streams(self) -> str:
        """Name of its random streams: episodes of a world pair have them in common."""
        return self.id if self.pair is None else self.pair

    @property
    def changed(self) -> frozenset[str]:
        """Ids of all instances that change."""
        return frozenset(change.instance for change in self.changes)

    @property
    def scripted(self) -> tuple[Change, ...]:
        """The changes of instances of the queried category; all others are of other categories."""
        return tuple(change for change in self.changes if change.category == self.category)

    @property
    def alike(self) -> tuple[Change, ...]:
        """The changes of the kind that defines the episode, including its own; for STABLE the kind of the distractor."""
        cause = self.target if self.distractor is None else self.distractor
        kind = next(change.kind for change in self.changes if change.instance == cause)
        return tuple(change for change in self.changes if change.kind == kind)

    @property
    def others(self) -> tuple[Change, ...]:
        """The changes of instances of other categories."""
        return tuple(change for change in self.changes if change.category != self.category)

    def alterations(self, visit: str) -> tuple[Alteration, ...]:
        """Return what differs from the untouched scene in the visit "first" or "second"."""
        return tuple(change.alteration for change in self.changes if change.in_first_visit == (visit == "first"))

    def rivals(self, now: Mapping[str, Point] = {}) -> tuple[Point, ...]:
        """Return the places that are wrong answers if success is exclusive, none if not. now: present places of movers."""
        if not self.rules.exclusive:
            return ()
        changed = (
            {change.instance: floor_point(change.before) for change in self.changes},
            {change.instance: floor_point(change.after) for change in self.changes},
        )
        return rivals(self.query, self.target, self.world_1, self.world_2, changed, self.stable, now)

    @property
    def gone(self) -> frozenset[str]:
        """Ids of the instances that are absent from visit 2."""
        return frozenset(change.instance for change in self.changes if change.kind == "disable")

    @property
    def settings(self) -> Settings:
        """The constants of the episode's protocol as settings; another constant raises AttributeError when it is read."""
        sections = {name: dict(getattr(self.protocol, name)) for name in type(self.protocol).model_fields}
        known = {"benchmark": {"seed": self.provenance.seed, "backend": self.backend}}
        return Settings.partial(known | sections, f"episode {self.id}")

    @property
    def states(self) -> tuple[WorldState, WorldState]:
        """W_1 and W_2 as Eq. 1 reads them: the path of an instance that a change set in motion is its track if it has none."""
        paths = {change.instance: change.path for change in self.changes if change.path}
        return self.world_1, self.world_2.with_tracks(paths)


def root_seed(episodes: Sequence[Episode]) -> int:
    """Return the root of the random numbers of episodes of one release; 0 for no episodes. ValueError where they have several."""
    seeds = sorted({episode.provenance.seed for episode in episodes})
    if len(seeds) > 1:
        raise ValueError(f"the episodes were made from the seeds {seeds}; use episodes of one release")
    return seeds[0] if seeds else 0
