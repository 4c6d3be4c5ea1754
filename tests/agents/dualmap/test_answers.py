"""The answers from DualMap's maps: a maintained one answers every relation alike, two maps follow the reference agent's rules."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.dualmap.agent import predict_maintained, predict_two_visits
from ovman.agents.dualmap.mapped import Mapped, RunMaps
from ovman.agents.interface import Abstention, AbstentionReason, Answer, Query, Relation, UniformPick
from ovman.records.visit import VisitPair
from tests.arms import CONFIG

CHAIR, LAMP = np.eye(4)[0], np.eye(4)[1]
FIRST, SECOND = "untouched", "displace-Chair"
STAYED, BEFORE, AFTER, OTHER = (0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (5.0, 5.0)


def entry(x: float, z: float, feature: np.ndarray = CHAIR, last_seen: int = 5) -> tuple:
    return (x, z), feature, last_seen


def mapped(entries: list[tuple]) -> Mapped:
    position, feature, last_seen = map(np.array, zip(*entries, strict=True))
    unread = np.zeros(len(entries), int)
    return Mapped(9, position, feature, unread, unread, unread, last_seen, tuple(unread[:, None]))


def maps(first: list[tuple], second: list[tuple], both: list[tuple]) -> RunMaps:
    return RunMaps({FIRST: mapped(first), SECOND: mapped(second)}, {(FIRST, SECOND): mapped(both)})


def context(*runs: RunMaps, run: int = 0, meant: tuple[int, ...] | None = None) -> SimpleNamespace:
    """meant: indices of the true objects, for an arm that is given its grounding."""
    return SimpleNamespace(
        made=lambda need, read: runs,
        noun={"chair": CHAIR}.__getitem__,
        privileged_grounding=meant is not None,
        run=run,
        settings=CONFIG,
        true_objects=lambda objects, *visits: meant,
        visits=VisitPair[str](first=FIRST, second=SECOND),
    )


CHANGED = maps(
    [entry(*STAYED), entry(*BEFORE), entry(*OTHER, LAMP)],
    [entry(*STAYED), entry(*AFTER, last_seen=7), entry(*OTHER, LAMP, last_seen=8)],
    [entry(*OTHER, LAMP), entry(*STAYED, 0.8 * CHAIR + 0.6 * LAMP), entry(*BEFORE), entry(*AFTER, 0.9 * CHAIR + 0.43589 * LAMP)],
)


@pytest.mark.parametrize("relation", Relation)
def test_a_maintained_map_answers_every_relation_with_its_best_match_or_a_true_object(relation):
    runs = CHANGED, maps([entry(0, 0)], [entry(0, 0)], [entry(7.0, 7.0)])
    for run, place in enumerate((BEFORE, (7.0, 7.0))):
        assert predict_maintained(Query("Chair", relation), context(*runs, run=run)) == (Answer(*place), None)
    outcome, _ = predict_maintained(Query("Chair", relation), context(CHANGED, meant=(1, 2, 3)))
    assert outcome == UniformPick((STAYED, BEFORE, AFTER))


@pytest.mark.parametrize("predict", [predict_maintained, predict_two_visits])
def test_without_a_true_object_it_abstains(predict):
    outcome, _ = predict(Query("Chair", Relation.MOVED), context(CHANGED, meant=()))
    assert outcome == Abstention(AbstentionReason.NOTHING_GROUNDED)


@pytest.mark.parametrize("meant", [None, (0, 1)])
@pytest.mark.parametrize(
    ("relation", "place"),
    [
        (Relation.MOVED, AFTER),
        (Relation.FORMER, BEFORE),
        (Relation.STABLE, STAYED),
        (Relation.APPEARED, AFTER),
        (Relation.REMOVED, BEFORE),
        (Relation.MOVING, AFTER),
    ],
)
def test_two_maps_are_read_by_the_rules_of_the_reference_agent(meant, relation, place):
    assert predict_two_visits(Query("Chair", relation), context(CHANGED, meant=meant)) == (Answer(*place), None)
