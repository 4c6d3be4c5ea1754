"""The table of episodes: what an agent is asked, and beside it, in columns of their own, what only the evaluator may read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ovman.agents.interface import VISITS
from ovman.cache import digest
from ovman.dataset.columns import Column, Kind, Table
from ovman.dataset.text import json_text
from ovman.records.episode import Episode

TOLD = ("camera", "primitives")
"""Sections of the protocol that an agent is told."""

TABLE = Table(
    "episodes",
    "A row is an episode: two tours of a home, and a query that only the change between them answers.",
    (
        Column("episode", Kind.TEXT, "id: floor plan, relation and number"),
        Column("split", Kind.TEXT, "split that it belongs to"),
        Column("backend", Kind.TEXT, "simulator that it was made and measured in"),
        Column("scene", Kind.TEXT, "iTHOR floor plan; no agent is told it"),
        Column("sentence", Kind.TEXT, "query in words"),
        Column("noun", Kind.TEXT, "noun of the query"),
        Column("category", Kind.TEXT, "query: category, as AI2-THOR calls it"),
        Column("relation", Kind.TEXT, "query: how the instance that is meant changed, or did not"),
        Column("first_tour", Kind.TEXT, "`tour` of the first visit's rows in `tours`"),
        Column("second_tour", Kind.TEXT, "`tour` of the second visit's rows in `tours`"),
        Column("spawn_x", Kind.REAL, "where a run begins, metres"),
        Column("spawn_z", Kind.REAL, "where a run begins, metres"),
        Column("spawn_yaw_deg", Kind.REAL, "which way the agent looks there, degrees"),
        Column("reachable_x_min", Kind.REAL, "box around what can be reached in the second visit, metres"),
        Column("reachable_x_max", Kind.REAL, "the same"),
        Column("reachable_z_min", Kind.REAL, "the same"),
        Column("reachable_z_max", Kind.REAL, "the same"),
        Column("protocol", Kind.JSON, "constants that an agent is told: camera, and primitives with the budget of actions"),
        Column("truth_target", Kind.TEXT, "id of the instance that is meant"),
        Column("truth_distractor", Kind.TEXT, "id of the instance that moves while the one that is meant does not; for STABLE"),
        Column("truth_answer_x", Kind.REAL, "answer (Eq. 3), metres"),
        Column("truth_answer_z", Kind.REAL, "answer (Eq. 3), metres"),
        Column("truth_navigable_x", Kind.REAL, "reachable position nearest to the answer, metres"),
        Column("truth_navigable_z", Kind.REAL, "reachable position nearest to the answer, metres"),
        Column("truth_shortest_path_m", Kind.REAL, "shortest path from spawn to answer (L* of Eq. 5), metres"),
        Column("truth_instances", Kind.WHOLE, "instances of the category"),
        Column("truth_changed", Kind.WHOLE, "instances of any category that change"),
        Column("truth_changes", Kind.JSON, "list of the changes: instance, kind, where it was and is, how it is brought about"),
        Column("truth_world_1", Kind.JSON, "instances of the category at the end of the first visit, metres"),
        Column("truth_world_2", Kind.JSON, "instances of the category at the end of the second visit, metres"),
        Column("truth_record", Kind.JSON, "whole record of the episode, from which `ovman eval` runs it"),
    ),
)


def rows(episodes: Sequence[Episode]) -> Iterator[dict[str, Any]]:
    """A row an episode, in their order."""
    for episode in episodes:
        record, box, (x, z) = episode.to_json(), episode.reachable_box, episode.answer
        yield TABLE.row(
            {name: record[name] for name in ("split", "backend", "scene", "sentence", "noun", "category", "relation")}
            | {"episode": episode.id}
            | {f"{which}_tour": tour_id(episode, which) for which in VISITS}
            | {f"spawn_{name}": record["spawn"][name] for name in ("x", "z", "yaw_deg")}
            | {"reachable_x_min": box.x[0], "reachable_x_max": box.x[1]}
            | {"reachable_z_min": box.z[0], "reachable_z_max": box.z[1]}
            | {"protocol": json_text({name: record["protocol"][name] for name in TOLD})}
            | {"truth_target": episode.target, "truth_distractor": episode.distractor}
            | {"truth_answer_x": x, "truth_answer_z": z}
            | {"truth_navigable_x": episode.nearest_navigable[0], "truth_navigable_z": episode.nearest_navigable[1]}
            | {"truth_shortest_path_m": episode.shortest_path_m, "truth_instances": episode.instances_in_category}
            | {"truth_changed": len(episode.changed), "truth_changes": json_text(record["changes"])}
            | {f"truth_{world}": json_text(record[world]) for world in ("world_1", "world_2")}
            | {"truth_record": json_text(record)}
        )


def tour_id(episode: Episode, which: str) -> str:
    """What the recorded tour of the visit "first" or "second" is called: equal for equal tours of episodes.

    The visit's own name says what was changed in it, so none of it is to be read in the id.
    """
    tour, camera = episode.tours[which].to_json(), episode.protocol.camera.model_dump(mode="json")
    return digest(episode.backend, episode.provenance.seed, episode.scene, episode.visits[which], tour, camera)[:16]
