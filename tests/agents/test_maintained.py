"""The reading of both visits as one map: a pick among what is grounded in it."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.interface import Abstention, AbstentionReason, Query, Relation, UniformPick
from ovman.agents.reference.agents import predict_maintained_map as predict
from ovman.perception.clusters import Cluster
from ovman.perception.records import name_pair, read_maps
from ovman.records.visit import VisitPair
from ovman.settings import Need
from tests.arms import CONFIG

CHAIR, LAMP = np.eye(2)


def cluster(feature: np.ndarray, *track: tuple[float, float]) -> Cluster:
    places = np.array(track)
    return Cluster(np.median(places, axis=0), feature, places, np.arange(len(places)))


CLUSTERS = (cluster(CHAIR, (0, 0), (0, 0), (3, 0)), cluster(LAMP, (5, 5)), cluster(CHAIR, (2, 1)))


class Context:
    settings = CONFIG
    visits = VisitPair[str](first="a", second="b")

    def __init__(self, clusters, handed=None):
        self._clusters, self._handed, self.privileged_grounding = clusters, handed, handed is not None

    def made(self, need, read):
        assert need is Need.MAINTAINED and read is read_maps
        return {name_pair("a", "b"): self._clusters}

    def noun(self, phrase):
        return CHAIR

    def true_objects(self, objects, *visits):
        assert visits == ("first", "second") and len(objects) == len(self._clusters)
        return self._handed


@pytest.mark.parametrize("relation", Relation)
def test_every_grounded_object_is_as_likely_whatever_the_relation(relation):
    moving = relation is Relation.MOVING
    places = ((2.0, 1.0), (3.0, 0.0)) if moving else ((0.0, 0.0), (2.0, 1.0))
    assert predict(Query("Chair", relation), Context(CLUSTERS)) == (UniformPick(places), None)
    assert predict(Query("Chair", relation), Context(CLUSTERS, (1,))) == (UniformPick(((5.0, 5.0),)), None)


def test_without_an_object_it_abstains():
    nothing = (Abstention(AbstentionReason.NOTHING_GROUNDED), None)
    assert predict(Query("Chair", Relation.MOVED), Context(CLUSTERS, ())) == nothing
    assert predict(Query("Chair", Relation.MOVED), Context(())) == nothing
