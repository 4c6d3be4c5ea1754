"""The joint agent with true names or identity: the truth replaces what its networks say, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.interface import Query, Relation
from ovman.agents.joint.agent import predict
from ovman.agents.joint.rungs import (
    SURE,
    correct_identity,
    predict_true_boxes,
    predict_true_identity,
    predict_true_names,
    predict_true_names_and_identity,
)
from ovman.records.task import Instance, WorldState
from tests.agents.joint.test_joint_answers import told
from tests.agents.joint.test_naming_objects import objects
from tests.agents.moved_chair import off
from tests.arms import CONFIG

RADIUS_M = CONFIG.success.radius_m


@pytest.fixture(scope="module")
def misled(home):
    """Inputs with an encoder that takes the noun for the instance that is seen most often."""
    context = told(home)
    toured = {"first": home.before, "second": home.after}
    common = np.bincount(home.after.instance).argmax()
    context.noun = lambda phrase: np.eye(len(home.chair))[common] if phrase == "chair" else np.zeros(len(home.chair))
    context.detections = lambda which: toured[which].detected
    of_chair = int(home.chair.argmax())
    context.true_objects = lambda objects, which: tuple(
        k for k, members in enumerate(objects.members) if (toured[which].instance[members] == of_chair).all()
    )
    context.world = lambda which: WorldState((Instance("chair", "Chair", *(home.old if which == "first" else home.new)),))
    return context


def test_true_boxes_are_answered_from_and_not_the_recorded_segments(home):
    context, toured = told(home), {"first": home.before, "second": home.after}
    context.true_detections, context.made = (lambda which: toured[which].detected), None
    for relation, at in ((Relation.MOVED, home.new), (Relation.FORMER, home.old)):
        assert off(predict_true_boxes(Query("Chair", relation), context)[0], at) <= RADIUS_M


@pytest.mark.parametrize("relation", [Relation.MOVED, Relation.FORMER])
def test_true_names_put_right_what_the_encoder_misleads(home, misled, relation):
    at = home.old if relation.past else home.new
    assert off(predict_true_names(Query("Chair", relation), misled)[0], at) <= RADIUS_M
    stable = Query("Chair", Relation.STABLE)
    assert predict(stable, misled) != predict_true_names(stable, misled)


def test_true_identity_tells_moved_from_appeared(home, misled):
    assert off(predict_true_identity(Query("Chair", Relation.MOVED), misled)[0], home.new) <= RADIUS_M
    misled.noun = lambda phrase: np.zeros(len(home.chair))
    moved, appeared = (predict_true_identity(Query("Chair", one), misled)[0] for one in (Relation.MOVED, Relation.APPEARED))
    assert off(moved, home.new) <= RADIUS_M < off(appeared, home.new)


def test_true_names_and_identity_answer_where_neither_the_encoder_nor_looks_do(home, misled):
    for relation, at in ((Relation.MOVED, home.new), (Relation.FORMER, home.old)):
        assert off(predict_true_names_and_identity(Query("Chair", relation), misled)[0], at) <= RADIUS_M


def test_identity_is_true_at_instances_and_the_agents_own_elsewhere():
    first, second = (objects((0.0, 0.0), (x, 0.0), (9.0, 9.0)) for x in (3.0, 6.0))
    worlds = [WorldState((Instance("a", "Chair", 0.1, 0.0), Instance("b", "Chair", x, 0.2))) for x in (3.0, 6.0)]
    same = np.full((3, 3), 0.5)
    correct_identity(same, first, second, (worlds[0], worlds[1]), CONFIG.joint, CONFIG.admissibility.tau_m)
    assert same.tolist() == [[-SURE, -SURE, 0.5], [-SURE, SURE, 0.5], [0.5, 0.5, 0.5]]
