"""Into how many objects targets fall, and what became of those that are not grounded."""

from __future__ import annotations

import csv
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import strategies as st

from ovman.agents.dualmap.mapped import OBJECT, Mapped, RunMaps, write
from ovman.analysis.maps import Target, count_fragments, find_target, objects_of_instances, write_dualmap
from ovman.perception.clusters import Cluster
from ovman.records.prediction import Evidence
from ovman.records.task import Relation
from tests.analysis.fabricated import named, static
from tests.episodes import released


def test_the_objects_of_an_instance_have_a_detection_of_it():
    scene = SimpleNamespace(objects=[SimpleNamespace(id=name) for name in "abc"])
    views = np.zeros(2, int)
    objects = [Cluster(np.zeros(2), np.zeros(3), np.zeros((2, 2)), views, np.array(members)) for members in ([0, 3], [1, 4], [2])]
    assert objects_of_instances(scene, np.array([0, 1, -1, -1, 0]), objects) == {"a": {0, 1}, "b": {1}, "c": set()}


@pytest.mark.parametrize(
    ("relation", "sets", "objects", "grounded"),
    [
        ("former", ((3,), (1, 2)), 2, True),
        ("former", ((3,), (2,)), 2, False),
        ("stable", ((5,), (1,)), 1, False),
        ("appeared", ((), (1,)), 1, True),
        ("removed", ((0,), ()), 2, True),
        ("removed", ((1,), (1,)), 2, False),
    ],
)
def test_a_target_is_grounded_where_it_is_so_in_every_visit_that_it_is_in(relation, sets, objects, grounded):
    episode = next(one for one in released() if one.relation == relation)
    # Two objects of the target in the first visit, one in the second.
    there = {episode.visits.first: {episode.target: {0, 3}}, episode.visits.second: {episode.target: {1}}}
    found = find_target(episode, Evidence(*sets, ()), static("a", 0, 1.0), there)
    assert found == Target(Relation(relation), objects, grounded, "success")


def test_objects_are_averaged_over_the_targets_that_are_seen():
    told = [(Relation.MOVED, 3), (Relation.MOVED, 0), (Relation.MOVED, 1), (Relation.STABLE, 2), (Relation.STABLE, 0)]
    rows = named(
        count_fragments(
            "a", [Target(relation, objects, objects > 0, "success" if objects else "abstained") for relation, objects in told]
        )
    )
    assert [(row.arm, row.relation, row.n, row.seen, row.objects, row.several) for row in rows] == [
        ("a", "moved", 3, 2, 2.0, 1),
        ("a", "stable", 2, 1, 2.0, 1),
        ("a", "all", 5, 3, 2.0, 2),
    ]


targets = st.lists(
    st.builds(
        Target,
        st.sampled_from(list(Relation)),
        st.integers(0, 3),
        st.booleans(),
        st.sampled_from(["success", "wrong", "abstained"]),
    ),
    max_size=20,
)


def mapped_of(objects: int, frames: int) -> Mapped:
    n = np.arange(objects)
    return Mapped(frames, np.zeros((objects, 2)), np.ones((objects, 3)), np.full(objects, OBJECT), n, n, n, tuple(n[:, None]))


def test_a_row_for_all_and_one_for_each_run_of_each_scene(tmp_path):
    one = [RunMaps({"a": mapped_of(n, 10), "b": mapped_of(n + 2, 20)}, {("a", "b"): mapped_of(n + 5, 30)}) for n in (3, 5)]
    write(tmp_path / "FloorPlan1.npz", one)
    write(tmp_path / "FloorPlan2.npz", [RunMaps({"a": mapped_of(40, 50)}, {})])
    write_dualmap([tmp_path / f"FloorPlan{n}.npz" for n in (1, 2)], tmp_path / "dualmap.csv")
    rows = list(csv.DictReader((tmp_path / "dualmap.csv").open()))
    found = {(row.pop("scene"), row.pop("memory"), row.pop("run")): [float(v) for v in row.values()] for row in rows}
    assert found == {
        ("all", "two visits", "all"): [5, 22, 12, 3, 40],
        ("all", "maintained map", "all"): [2, 30, 9, 8, 10],
        ("FloorPlan1", "two visits", "0"): [2, 15, 4, 3, 5],
        ("FloorPlan1", "maintained map", "0"): [1, 30, 8, 8, 8],
        ("FloorPlan1", "two visits", "1"): [2, 15, 6, 5, 7],
        ("FloorPlan1", "maintained map", "1"): [1, 30, 10, 10, 10],
        ("FloorPlan2", "two visits", "0"): [1, 50, 40, 40, 40],
    }
