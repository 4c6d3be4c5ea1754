"""The reference agent's arms: with true positions as released, one maintained map, and the agents that drive."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents import interface
from ovman.agents.interface import Abstention, AbstentionReason, Action, Agent, Answer, Query, Relation, UniformPick, Visit
from ovman.agents.pilot import Pilot
from ovman.agents.reference.agents import (
    PositionsTwoVisits,
    SingleVisit,
    TwoVisits,
    answer_positions,
    collect_world,
    predict_maintained_map,
    predict_positions_single_visit,
    predict_positions_two_visits,
)
from ovman.perception.clusters import Cluster
from ovman.perception.records import name_pair, read_maps
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.task import Instance, WorldState
from ovman.records.visit import Sightings, VisitPair
from ovman.settings import Need
from ovman.task import recorded_world
from tests.arms import CONFIG
from tests.episodes import DATA

GATE = CONFIG.association.gate_m
GRID = np.array([(0.25 * i, 0.25 * j) for i in range(17) for j in range(17)])


def recorded() -> list[tuple[Episode, SimpleNamespace]]:
    """The released episodes with what their tours recorded."""
    sightings = {record.episode: record.sightings for record in Sightings.read(DATA / "sightings" / "main.jsonl")}
    made = []
    for episode in Episode.load(DATA / "episodes" / "main.jsonl"):
        seen, box = sightings[episode.id], episode.reachable_box
        worlds = {
            which: recorded_world(seen[which], episode.category, CONFIG.admissibility.min_mask_px)
            for which in ("first", "second")
        }
        reachable = np.array([box.x, box.z]).T
        made.append((episode, SimpleNamespace(settings=CONFIG, world=worlds.__getitem__, reachable=reachable)))
    return made


@pytest.mark.parametrize("predict", [predict_positions_two_visits, predict_positions_single_visit])
def test_the_answers_from_positions_are_the_released_ones(predict):
    arm = predict.__name__.removeprefix("predict_")
    answers = [Prediction.of(episode.id, arm, 0, *predict(episode.query, context)).to_line() for episode, context in recorded()]
    assert answers == (DATA / "predictions" / "main" / f"{arm}.jsonl").read_text().splitlines(keepends=True)


# Driving with true positions ----------------------------------------------------------------------------------------------------


def at(name: str, x: float, z: float, category: str = "Chair") -> interface.SeenInstance:
    return interface.SeenInstance(name, category, x, z)


def view(
    *seen: interface.SeenInstance, x: float = 1.0, z: float = 1.0, yaw: float = 0.0, positions: bool = True, moved: bool = True
) -> interface.Observation:
    pose = interface.CameraPose(x, 0.9, z, yaw, 0.0)
    return interface.Observation(None, None, pose, 90.0, positions=seen if positions else None, last_action_succeeded=moved)


def test_what_is_remembered_is_the_last_position_and_the_track_of_each():
    visit = Visit([view(at("b", 0, 0), at("a", 3, 3, "Vase")), view(positions=False), view(at("b", 1, 0))], GRID)
    assert collect_world(visit) == WorldState(
        (Instance("a", "Vase", 3, 3, ((3, 3),)), Instance("b", "Chair", 1, 0, ((0, 0), (1, 0))))
    )


def driven(first, second, relation, *observations, reachable=GRID) -> list[Action]:
    agent = PositionsTwoVisits(SimpleNamespace(pilot=Pilot(CONFIG.primitives, np.random.default_rng(0)), settings=CONFIG))
    agent.familiarise(Visit(first, reachable))
    agent.revisit(Visit(second, reachable))
    agent.ask(Query("Chair", relation))
    return [agent.act(observation) for observation in observations]


MOVED_CHAIR = [view(at("k", 3.0, 1.0))], [view(at("other name", 1.0, 3.0))]
STILL = [view(at("k", 3.0, 1.0), at("vase", 1.0, 1.0, "Vase"))]
TOUR = [view(at("still", 0.5, 3.5), at("mover", x, 3.0)) for x in (1.0, 3.5, 2.0)]
LIVE = at("still", 3.0, 3.0)


@pytest.mark.parametrize(
    ("tours", "relation", "seen", "actions"),
    [
        (MOVED_CHAIR, Relation.MOVED, [view(x=1.0, z=2.5)], [Action.STOP]),
        (MOVED_CHAIR, Relation.MOVED, [view(x=1.0, z=2.5, yaw=90.0)], [Action.ROTATE_LEFT]),
        (MOVED_CHAIR, Relation.MOVED, [view(x=1.0, z=2.5, yaw=270.0)], [Action.ROTATE_RIGHT]),
        (MOVED_CHAIR, Relation.MOVED, [view()], [Action.MOVE_AHEAD]),
        (MOVED_CHAIR, Relation.FORMER, [view(x=2.5, yaw=90.0)], [Action.STOP]),
        ((STILL, STILL), Relation.MOVED, [view()], [Action.ABSTAIN]),
        ((STILL, STILL), Relation.MOVING, [view()], [Action.ABSTAIN]),
        # It follows the mover that it chose while it sees it, and then goes to where the mover was last recorded.
        ((TOUR, TOUR), Relation.MOVING, [view(LIVE, at("mover", 3.0, 3.0), x=3.0, z=2.5)], [Action.STOP]),
        (
            (TOUR, TOUR),
            Relation.MOVING,
            [view(LIVE, x=3.0, z=2.5, yaw=180.0), view(LIVE, x=2.0, z=2.5)],
            [Action.ROTATE_RIGHT, Action.STOP],
        ),
        ((TOUR, TOUR), Relation.STABLE, [view(LIVE, x=0.5, z=3.0)], [Action.STOP]),
    ],
)
def test_it_drives_to_what_the_tours_tell_faces_it_and_else_abstains(tours, relation, seen, actions):
    assert driven(*tours, relation, *seen) == actions


def test_in_a_corridor_it_waits_for_what_moves_and_gives_up_on_what_stands_still():
    """Something blocks the only way. A mover may leave it."""
    corridor = GRID[GRID[:, 0] == 1.0]
    tour = [view(at("still", 1.0, 4.0), at("mover", 1.0, z)) for z in (3.0, 4.0)]
    for relation, next_action in ((Relation.MOVING, Action.ROTATE_LEFT), (Relation.STABLE, Action.ABSTAIN)):
        actions = driven(tour, tour, relation, view(z=0.0), view(z=0.0, moved=False), reachable=corridor)
        assert actions == [Action.MOVE_AHEAD, next_action]


def test_positions_alone_are_compared_and_no_features():
    """An instance a little nearer than the gate is the same one, at the gate it is another."""
    for shift, answered in ((GATE, Answer(GATE, 0.0)), (float(np.nextafter(GATE, 0.0)), None)):
        world_1, world_2 = (WorldState((Instance(name, "Chair", x, 0.0, ((x, 0.0),)),)) for name, x in (("a", 0.0), ("b", shift)))
        got = answer_positions(Query("Chair", Relation.APPEARED), world_1, world_2, CONFIG)
        assert got == (answered or Abstention("no_candidate"))


# One maintained map -------------------------------------------------------------------------------------------------------------

CHAIR, LAMP = np.eye(2)


def cluster(feature: np.ndarray, *track: tuple[float, float]) -> Cluster:
    places = np.array(track)
    return Cluster(np.median(places, axis=0), feature, places, np.arange(len(places)))


CLUSTERS = (cluster(CHAIR, (0, 0), (0, 0), (3, 0)), cluster(LAMP, (5, 5)), cluster(CHAIR, (2, 1)))


def maintained(clusters, handed=None) -> SimpleNamespace:
    return SimpleNamespace(
        settings=CONFIG,
        visits=VisitPair[str](first="a", second="b"),
        made=lambda need, read: {(Need.MAINTAINED, read_maps): {name_pair("a", "b"): clusters}}[need, read],
        noun=lambda phrase: CHAIR,
        privileged_grounding=handed is not None,
        true_objects=lambda objects, *visits: {("first", "second"): handed}[visits],
    )


@pytest.mark.parametrize("relation", Relation)
def test_every_grounded_object_is_as_likely_whatever_the_relation(relation):
    moving = relation is Relation.MOVING
    places = ((2.0, 1.0), (3.0, 0.0)) if moving else ((0.0, 0.0), (2.0, 1.0))
    assert predict_maintained_map(Query("Chair", relation), maintained(CLUSTERS)) == (UniformPick(places), None)
    assert predict_maintained_map(Query("Chair", relation), maintained(CLUSTERS, (1,))) == (UniformPick(((5.0, 5.0),)), None)
    for nothing in (maintained(CLUSTERS, ()), maintained(())):
        expected = Abstention(AbstentionReason.NOTHING_GROUNDED), None
        assert predict_maintained_map(Query("Chair", relation), nothing) == expected


# Driving on maps ----------------------------------------------------------------------------------------------------------------

GROUND = np.array([[0.0, 0.0], [1.0, 1.0]])
HERE, THERE = cluster(CHAIR, (0, 0)), cluster(CHAIR, (4, 3))
MAPS = {"empty": (), "before": (HERE,), "after": (HERE, THERE)}


@pytest.mark.parametrize(
    ("kind", "first", "second", "relation", "places"),
    [
        (TwoVisits, "before", "after", Relation.APPEARED, [(4.0, 3.0)]),
        (TwoVisits, "after", "before", Relation.REMOVED, [(4.0, 3.0)]),
        (TwoVisits, "empty", "empty", Relation.STABLE, []),
        (SingleVisit, "before", "after", Relation.APPEARED, [(0.0, 0.0), (4.0, 3.0)]),
        (SingleVisit, "before", "after", Relation.REMOVED, None),
        (SingleVisit, "before", "empty", Relation.STABLE, []),
    ],
)
def test_agents_on_maps_drive_to_one_of_the_places_or_anywhere_or_abstain(wheels, kind, first, second, relation, places):
    context = SimpleNamespace(
        pilot=wheels,
        mapper=lambda visit: MAPS[visit.content],
        noun={"chair": CHAIR}.__getitem__,
        settings=CONFIG,
        rng=np.random.default_rng(0),
    )
    agent = kind(context)
    assert isinstance(agent, Agent) and agent.looks is False
    agent.familiarise(Visit((), np.empty((0, 2)), first))
    agent.revisit(Visit((), GROUND, second))
    agent.ask(Query("Chair", relation))
    assert wheels.told[0] is GROUND and wheels.told[1] is relation
    assert agent.act(view()) is (Action.ABSTAIN if places == [] else Action.STOP)
    if places is None:
        assert all(0.0 <= metres <= 1.0 for metres in wheels.goals[0])
    else:
        assert {*wheels.goals} <= {*places} and len(wheels.goals) == bool(places)
