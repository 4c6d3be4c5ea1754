"""The record of an episode, "ovman-episode/1": what shared files hold, read, checked and written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.task.certification import CertificationRun
from ovman.task.change import Change
from ovman.task.pose import Spawn, point_to_json, read_point, read_points
from ovman.task.record import Node, RecordError, line, records, rounded
from ovman.task.referents import Query
from ovman.task.relation import Relation
from ovman.task.world_state import Instance, Point, WorldState

SCHEMA = "ovman-episode/1"
BACKENDS = ("embedded", "thor")


@dataclass(frozen=True)
class Episode:
    """One released episode. Floor-plane coordinates (x, z) in metres, world frame.

    world_1, world_2: the present instances as the two tours recorded them; answer: Eq. 3 at the end of visit 2;
    nearest_navigable: nu(answer); shortest_path_m: L* of Eq. 5; visits: names of the recorded visits, first and second;
    drift_m: how far each changed instance was from its placement. Raises ValueError for a record that contradicts itself.
    """

    id: str
    split: str
    backend: str
    scene: str
    relation: Relation
    category: str
    noun: str
    sentence: str
    target: str
    distractor: str | None
    changes: tuple[Change, ...]
    spawn: Spawn
    answer: Point
    nearest_navigable: Point
    shortest_path_m: float
    instances_in_category: int
    world_1: WorldState
    world_2: WorldState
    visits: tuple[str, str]
    drift_m: Mapping[str, float]
    certification: tuple[CertificationRun, ...]

    def __post_init__(self) -> None:
        scene, _, rest = self.id.partition("/")
        relation, _, number = rest.partition("/")
        if (scene, relation) != (self.scene, self.relation) or not number.isdigit():
            raise ValueError(f"id is {self.id!r}; write {self.scene}/{self.relation}/ and a number")
        if self.instances_in_category < 2:
            raise ValueError(f"instances_in_category is {self.instances_in_category}; a query needs a category with at least 2")
        if (self.distractor is not None) != (self.relation is Relation.STABLE):
            raise ValueError(f"distractor is {self.distractor!r}; STABLE has one and no other relation does")
        visit, world = ("world_1", self.world_1) if self.relation.past else ("world_2", self.world_2)
        if self.target not in world or world[self.target].category != self.category:
            raise ValueError(f"target {self.target!r} is no {self.category} of {visit}, which {self.relation} answers from")
        cause = self.distractor if self.distractor is not None else self.target
        if cause not in self.changed:
            raise ValueError(f"changes do not hold {cause!r}, whose change defines the episode")

    @property
    def query(self) -> Query:
        return Query(self.category, self.relation)

    @property
    def changed(self) -> frozenset[str]:
        """Ids of the instances of the scripted changes."""
        return frozenset(change.instance for change in self.changes)

    @property
    def states(self) -> tuple[WorldState, WorldState]:
        """W_1 and W_2 as Eq. 1 reads them: the path of an instance that a change set in motion is its track if it has none."""
        paths = {change.instance: change.path for change in self.changes if change.path}
        return self.world_1, WorldState(
            tuple(
                Instance.tracked(instance.id, instance.category, paths[instance.id])
                if instance.id in paths and not instance.track
                else instance
                for instance in self.world_2
            )
        )

    def to_json(self) -> dict[str, Any]:
        """The record, rounded, its keys in the order that the schema lists them."""
        return rounded(
            {
                "schema": SCHEMA,
                "id": self.id,
                "split": self.split,
                "backend": self.backend,
                "scene": self.scene,
                "relation": str(self.relation),
                "category": self.category,
                "noun": self.noun,
                "sentence": self.sentence,
                "target": self.target,
                "distractor": self.distractor,
                "changes": [change.to_json() for change in self.changes],
                "spawn": self.spawn.to_json(),
                "answer": point_to_json(self.answer),
                "nearest_navigable": point_to_json(self.nearest_navigable),
                "shortest_path_m": float(self.shortest_path_m),
                "instances_in_category": self.instances_in_category,
                "world_1": [_instance_to_json(instance) for instance in self.world_1],
                "world_2": [_instance_to_json(instance) for instance in self.world_2],
                "visits": {"first": self.visits[0], "second": self.visits[1]},
                "drift_m": {key: float(metres) for key, metres in self.drift_m.items()},
                "certification": [run.to_json() for run in self.certification],
            }
        )

    @staticmethod
    def from_json(record: Any, place: str = "episode") -> Episode:
        """The episode of a record; keys that the schema does not know are passed over. `place` names the file and line.

        Raises RecordError, one line with place, key and remedy, for a key that is missing, a value of the wrong kind, another
        schema, or a record that contradicts itself.
        """
        node = Node(record, place)
        schema = node["schema"]
        if schema.value != SCHEMA:
            raise schema.fail(f"expected {SCHEMA!r}, found {schema.value!r}", "make the file again with this version of ovman")
        try:
            return _episode(node)
        except RecordError:
            raise
        except ValueError as error:
            raise node.fail(str(error), "correct the record or make the file again") from None


def read_episodes(path: Path) -> list[Episode]:
    """The episodes of a JSONL file in its order. Raises RecordError as Episode.from_json does, and where an id occurs twice."""
    episodes: dict[str, Episode] = {}
    for place, record in records(path):
        episode = Episode.from_json(record, place)
        if episode.id in episodes:
            raise RecordError(f"{place}: id: {episode.id} is in the file already; remove one of the two")
        episodes[episode.id] = episode
    return list(episodes.values())


def episode_lines(episodes: Iterable[Episode]) -> str:
    """The episodes as the text of a JSONL file."""
    return "".join(line(episode.to_json()) for episode in episodes)


def _episode(node: Node) -> Episode:
    visits = node["visits"]
    return Episode(
        id=node["id"].text(),
        split=node["split"].text(),
        backend=node["backend"].one_of(BACKENDS),
        scene=node["scene"].text(),
        relation=Relation(node["relation"].one_of(list(Relation))),
        category=node["category"].text(),
        noun=node["noun"].text(),
        sentence=node["sentence"].text(),
        target=node["target"].text(),
        distractor=node["distractor"].optional(Node.text),
        changes=tuple(Change.read(change) for change in node["changes"].elements()),
        spawn=Spawn.read(node["spawn"]),
        answer=read_point(node["answer"]),
        nearest_navigable=read_point(node["nearest_navigable"]),
        shortest_path_m=node["shortest_path_m"].length(),
        instances_in_category=node["instances_in_category"].integer(),
        world_1=_world(node["world_1"]),
        world_2=_world(node["world_2"]),
        visits=(visits["first"].text(), visits["second"].text()),
        drift_m={key: metres.length() for key, metres in node["drift_m"].items()},
        certification=tuple(CertificationRun.read(run) for run in node["certification"].elements()),
    )


def _instance(node: Node) -> Instance:
    track = read_points(node["track"]) if "track" in node.mapping() else ()
    return Instance(node["id"].text(), node["category"].text(), *read_point(node), track)


def _instance_to_json(instance: Instance) -> dict[str, Any]:
    record: dict[str, Any] = {"id": instance.id, "category": instance.category, **point_to_json(instance.position)}
    if instance.track:
        record["track"] = [point_to_json(point) for point in instance.track]
    return record


def _world(node: Node) -> WorldState:
    return WorldState(tuple(_instance(instance) for instance in node.elements()))
