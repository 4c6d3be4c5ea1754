"""What is withheld from an arm: it is asked something else, or a visit showed nothing, and nothing of it is read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman.agents.interface import Answer, Query, Relation
from ovman.evaluation.observations import ObservationStore, Perceived
from ovman.evaluation.predictions import predict, query_of
from ovman.evaluation.supervision import AgentError
from ovman.language import noun
from ovman.language.vocabulary import nouns
from ovman.perception.clusters import Cluster
from ovman.perception.labels import categories_of
from ovman.records.visit import VisitPair
from ovman.settings import Need, Withheld
from tests.arms import CONFIG
from tests.episodes import released, scene_record
from tests.runs import job

ARMS = {arm.withheld: arm.name for arm in CONFIG.arms.values() if arm.withheld is not None and Need.MAPS in arm.needs}
EPISODES = {relation: next(e for e in released() if e.relation is relation) for relation in Relation}
RUNS = range(60)
KINDS = ("Chair", "Vase", "Statue")
FEATURES = dict(zip(map(noun, KINDS), np.eye(3), strict=True))


def cluster(kind: str, *track: tuple[float, float]) -> Cluster:
    places = np.array(track, float)
    return Cluster(places[-1], FEATURES[noun(kind)], places, np.arange(len(places)))


FIRST = (cluster("Chair", (0, 0)), cluster("Vase", (4, 0)), cluster("Statue", (8, 0)))
SECOND = (cluster("Chair", (0, 3)), cluster("Vase", (4, 0)), cluster("Statue", (8, 0.5)))


class Maps(dict):
    """Maps by the names of visits; those of a withheld visit must not be asked for."""

    def __init__(self, poisoned: str | None, **maps):
        super().__init__(maps)
        self._poisoned = poisoned

    def __getitem__(self, name):
        assert name != self._poisoned, f"{name} was read"
        return super().__getitem__(name)


def answered(arm: str, query: Query, maps: Maps | None = None, run: int = 0, **categories):
    """What an arm answers to an episode of the query's relation with a category and maps of ours."""
    of_arm, settings = job(arm)
    episode = EPISODES[query.relation].model_copy(
        update={"category": query.category, "visits": VisitPair[str](first="before", second="after")}
    )
    store = ObservationStore(of_arm, settings, 90.0, Path("no such directory"))
    store.__dict__["perceived"] = Perceived(maps or Maps(None, before=FIRST, after=SECOND), FEATURES)
    store.__dict__["_nouns"] = FEATURES
    store._files = {"nouns": Path("read already")}
    return predict(of_arm, episode, settings, store, run=run, **categories)[0]


@pytest.mark.parametrize("relation", Relation)
def test_a_withheld_noun_makes_all_nouns_equal_and_all_objects_meant(relation):
    found = {repr(answered(ARMS[Withheld.NOUN], Query(category, relation))) for category in (*KINDS, "Sofa")}
    assert len(found) == 1
    given = {repr(answered("two_visits", Query(category, relation))) for category in KINDS}
    assert len(given) > 1


@pytest.mark.parametrize("relation", Relation)
@pytest.mark.parametrize(("withheld", "lacking"), [(Withheld.FIRST_VISIT, "before"), (Withheld.SECOND_VISIT, "after")])
def test_a_withheld_visit_is_not_read_and_does_not_matter(relation, withheld, lacking):
    query, there = Query("Chair", relation), {"before": FIRST, "after": SECOND}
    poisoned = answered(ARMS[withheld], query, Maps(lacking, **there))
    other = answered(ARMS[withheld], query, Maps(None, **(there | {lacking: (cluster("Chair", (9, 9)),)})))
    empty = answered("two_visits", query, Maps(None, **(there | {lacking: ()})))
    assert poisoned == other == empty


@pytest.mark.parametrize(("withheld", "lacking"), [(Withheld.FIRST_VISIT, "first"), (Withheld.SECOND_VISIT, "second")])
def test_frames_of_a_withheld_visit_are_not_read_and_files_of_both_visits_are_refused(withheld, lacking, monkeypatch):
    def reading(query, context):
        shown = {which: len(context.tour(which).observations) for which in ("first", "second")}
        if query.relation is Relation.STABLE:
            context.made("maps", Path.read_bytes)
        return Answer(float(shown["first"]), float(shown["second"])), None

    class Store(ObservationStore):
        def visit(self, name, reachable):
            assert name != EPISODES[Relation.MOVED].visits[lacking], "read"
            from ovman.agents.interface import Visit

            return Visit((None, None, None), reachable)

    of_arm, settings = job(ARMS[withheld])
    arm = of_arm.model_copy(update={"needs": (Need.TOURS, Need.MAPS)})
    monkeypatch.setattr("ovman.evaluation.predictions.load_agent", lambda *_: reading)
    store = Store(arm, settings, 90.0, Path("no such directory"))
    expected = Answer(0.0, 3.0) if lacking == "first" else Answer(3.0, 0.0)
    assert predict(arm, EPISODES[Relation.MOVED], settings, store)[0] == expected
    with pytest.raises(AgentError, match=f"arms.{arm.name} is withheld the {lacking} visit; ask for its map or its tour"):
        predict(
            arm, EPISODES[Relation.STABLE].model_copy(update={"visits": VisitPair[str](first="a", second="b")}), settings, store
        )


def test_a_relation_is_drawn_from_all_six_and_the_noun_is_kept():
    for relation, episode in EPISODES.items():
        drawn = [query_of(episode, Withheld.RELATION, run) for run in RUNS]
        assert {query.relation for query in drawn} == set(Relation), relation
        assert {query.category for query in drawn} == {episode.category}


def test_a_wrong_noun_is_of_another_thing_in_the_scene_and_no_synonym():
    for episode in EPISODES.values():
        scene = scene_record(episode.scene)
        categories = {*categories_of(scene).values()}
        drawn = [query_of(episode, Withheld.NOUN_WRONG, run, categories) for run in RUNS]
        assert {query.relation for query in drawn} == {episode.relation}
        names = {query.category for query in drawn}
        assert len(names) > 3 and names <= categories and episode.category in categories
        assert not [name for name in names if set(nouns(name)) & set(nouns(episode.category))]


@pytest.mark.parametrize("withheld", [None, *Withheld])
def test_a_draw_is_of_the_episode_and_the_run_and_what_is_not_withheld_is_asked(withheld):
    for episode in EPISODES.values():
        first, again = (query_of(episode, withheld, 1, ("Chair", "Vase", "Sofa", "Lamp")) for _ in range(2))
        assert first == again
        if withheld is None or withheld.visit is not None:
            assert first == Query(episode.category, episode.relation)
        elif withheld is Withheld.NOUN:
            assert first == Query("", episode.relation)
