"""The joint agent with true names or identity: the truth replaces what its networks say, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.interface import Query, Relation
from ovman.agents.joint.agent import predict
from ovman.agents.joint.decision import Objects
from ovman.agents.joint.rungs import SURE, correct_identity, predict_true_identity, predict_true_names
from ovman.records.task import Instance, WorldState
from tests.agents.joint.test_joint_answers import told
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


def test_identity_is_true_at_instances_and_the_agents_own_elsewhere():
    at = [(0.0, 0.0), (3.0, 0.0), (9.0, 9.0)]
    here = Objects(np.array([(x, 0.5, z) for x, z in at]), np.zeros((3, 1)), np.zeros(3), np.zeros(3))
    own = WorldState((Instance("a", "Chair", 0.1, 0.0), Instance("b", "Chair", 3.0, 0.2)))
    other = WorldState((Instance("a", "Chair", 0.1, 0.0), Instance("b", "Chair", 6.0, 0.0)))
    found = correct_identity(here, np.array([0.5, 0.5, 0.5]), own, other, CONFIG.joint, CONFIG.admissibility.tau_m)
    assert found.tolist() == [-SURE, SURE, 0.5]
