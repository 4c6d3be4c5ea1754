"""The diagnostic arms with true positions: their released answers, their thresholds, and the way to what they follow."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.interface import (
    Abstention,
    Action,
    Answer,
    CameraPose,
    Observation,
    Query,
    Relation,
    SeenInstance,
    UniformBox,
    Visit,
)
from ovman.agents.pilot import Pilot
from ovman.agents.reference.agents import (
    PositionsTwoVisits,
    answer_positions,
    collect_world,
    predict_positions_single_visit,
    predict_positions_two_visits,
)
from ovman.agents.reference.association import Association
from ovman.agents.reference.reasoning import decide
from ovman.records.episode import Episode
from ovman.records.task import Instance, WorldState
from ovman.records.visit import Sightings
from ovman.task import recorded_world
from tests.arms import CONFIG
from tests.episodes import DATA

TAU, SPREAD, GATE = CONFIG.admissibility.tau_m, CONFIG.association.track_spread_m, CONFIG.association.gate_m
GRID = np.array([(0.25 * i, 0.25 * j) for i in range(17) for j in range(17)])


class Recorded:
    """What the arms with true positions read of an episode."""

    settings = CONFIG

    def __init__(self, worlds: dict[str, WorldState], reachable: np.ndarray) -> None:
        self._worlds, self.reachable = worlds, reachable

    def world(self, which: str) -> WorldState:
        return self._worlds[which]


def recorded() -> list[tuple[Episode, Recorded]]:
    """The released episodes with what their tours recorded."""
    sightings = {record.episode: record.sightings for record in Sightings.read(DATA / "sightings" / "main.jsonl")}
    made = []
    for episode in Episode.load(DATA / "episodes" / "main.jsonl"):
        seen, box = sightings[episode.id], episode.reachable_box
        worlds = {
            which: recorded_world(seen[which], episode.category, CONFIG.admissibility.min_mask_px)
            for which in ("first", "second")
        }
        made.append((episode, Recorded(worlds, np.array([box.x, box.z]).T)))
    return made


def released(arm: str) -> dict[str, dict]:
    lines = (DATA / "predictions" / "main" / f"{arm}.jsonl").read_text().splitlines()
    return {record["episode"]: record for record in map(json.loads, lines)}


def test_the_answers_of_two_visits_are_the_released_ones():
    expected = released("positions_two_visits")
    for episode, context in recorded():
        outcome, _ = predict_positions_two_visits(episode.query, context)
        record = expected.pop(episode.id)
        if isinstance(outcome, Abstention):
            assert record["abstain"] == outcome.reason
        else:
            assert (round(outcome.x, 4), round(outcome.z, 4)) == (record["x"], record["z"])
    assert expected == {}


def test_the_picks_of_a_single_visit_are_the_released_ones():
    expected = released("positions_single_visit")
    for episode, context in recorded():
        outcome, _ = predict_positions_single_visit(episode.query, context)
        record = expected.pop(episode.id)
        if isinstance(outcome, UniformBox):
            box = record["box"]
            assert (outcome.x_min, outcome.z_min, outcome.x_max, outcome.z_max) == pytest.approx(
                (box["x_min"], box["z_min"], box["x_max"], box["z_max"])
            )
        else:
            assert [(round(x, 4), round(z, 4)) for x, z in outcome.candidates] == [(c["x"], c["z"]) for c in record["candidates"]]
    assert expected == {}


# --- thresholds of the decision -------------------------------------------------------------------


def decided(relation, p_1, p_2, association, tracks=()):
    return decide(relation, p_1, p_2, association, tracks, tau_m=TAU, track_spread_m=SPREAD)


def test_tau_counts_as_moved_and_not_as_stable():
    one = Association(((0, 0),), (), ())
    for displacement, moved in ((TAU, True), (np.nextafter(TAU, 0.0), False)):
        ends = [(0.0, 0.0)], [(float(displacement), 0.0)]
        assert isinstance(decided(Relation.MOVED, *ends, one), Answer) is moved
        assert isinstance(decided(Relation.FORMER, *ends, one), Answer) is moved
        assert isinstance(decided(Relation.STABLE, *ends, one), Answer) is not moved
    assert decided(Relation.MOVED, *ends, one).reason == "displacement_below_tau"
    assert decided(Relation.STABLE, [(0, 0)], [(TAU, 0)], one).reason == "displacement_above_tau"


@pytest.mark.parametrize("metres", [(1.0, 0.8, 0.9), (0.8, 1.0, 0.9), (0.8, 0.9, 1.0)])
def test_the_largest_displacement_has_moved_and_the_smallest_is_stable(metres):
    p_1 = [(5.0 * k, 0.0) for k in range(3)]
    p_2 = [(x, moved) for (x, _), moved in zip(p_1, metres, strict=True)]
    pairs = Association(((0, 0), (1, 1), (2, 2)), (), ())
    most, least = metres.index(1.0), metres.index(0.8)
    assert decided(Relation.MOVED, p_1, p_2, pairs) == Answer(*p_2[most])
    assert decided(Relation.FORMER, p_1, p_2, pairs) == Answer(*p_1[most])
    nearer = [(x, z - 0.3) for x, z in p_2]
    assert decided(Relation.STABLE, p_1, nearer, pairs) == Answer(*nearer[least])


def test_of_equal_displacements_the_pair_of_smallest_positions_is_taken():
    """Both pairs move by 1 m, then both by nothing; positions of visit 1 come first for MOVED, of visit 2 for STABLE."""
    p_1, p_2 = [(5.0, 0.0), (0.0, 7.0)], [(4.0, 0.0), (1.0, 7.0)]
    both = Association(((0, 0), (1, 1)), (), ())
    assert decided(Relation.MOVED, p_1, p_2, both) == Answer(1.0, 7.0)
    assert decided(Relation.FORMER, p_1, p_2, both) == Answer(0.0, 7.0)
    swapped = Association(((0, 1), (1, 0)), (), ())
    assert decided(Relation.MOVED, p_1, p_2[::-1], swapped) == Answer(1.0, 7.0)
    assert decided(Relation.STABLE, p_1, p_1, both) == Answer(0.0, 7.0)
    assert decided(Relation.STABLE, [(0, 9), (0, 3)], [(0, 9), (0, 3)], both) == Answer(0.0, 3.0)
    same = [(2.0, 2.0), (2.0, 2.0)]
    assert decided(Relation.FORMER, [(3.0, 2.0), (1.0, 2.0)], same, both) == Answer(1.0, 2.0)
    assert decided(Relation.MOVED, same, [(3.0, 2.0), (1.0, 2.0)], both) == Answer(1.0, 2.0)


def test_of_unmatched_instances_the_farthest_and_then_the_one_of_smallest_x_then_z_is_taken():
    none = Association((), (), (0, 1, 2))
    spots = [(3.0, 0.0), (0.0, 3.0), (-1.0, 0.0)]
    assert decided(Relation.APPEARED, [(0.0, 0.0)], spots, none) == Answer(0.0, 3.0)
    assert decided(Relation.APPEARED, [(0.0, 0.0)], spots, Association((), (), (0, 2))) == Answer(3.0, 0.0)
    assert decided(Relation.APPEARED, [], spots, none).reason == "no_counterpart"
    gone = Association((), (0, 1, 2), ())
    assert (
        decided(Relation.REMOVED, spots, [(0.0, 0.0)], gone)
        == decided(Relation.FORMER, spots, [(0.0, 0.0)], gone)
        == Answer(0.0, 3.0)
    )
    # The nearest instance of the other visit counts, matched or not.
    assert decided(Relation.MOVED, [(0.0, 0.0), (0.0, 3.5)], spots, none) == Answer(3.0, 0.0)


@pytest.mark.parametrize("relation", list(Relation))
def test_without_instances_there_is_no_candidate(relation):
    assert decided(relation, [], [], Association((), (), ())) == Abstention("no_candidate")


@pytest.mark.parametrize("name, p_1, p_2", [("p_1", [(1, 2, 3)], [(0, 0)]), ("p_2", [(0, 0)], [(1, 2, 3)])])
def test_a_wrong_position_is_named(name, p_1, p_2):
    with pytest.raises(ValueError, match=f"^{name} must have"):
        decided(Relation.MOVED, p_1, p_2, Association((), (), ()))


# --- the agent ------------------------------------------------------------------------------------


def at(name: str, x: float, z: float, category: str = "Chair") -> SeenInstance:
    return SeenInstance(name, category, x, z)


def view(
    *seen: SeenInstance, x: float = 1.0, z: float = 1.0, yaw: float = 0.0, positions: bool = True, moved: bool = True
) -> Observation:
    pose = CameraPose(x, 0.9, z, yaw, 0.0)
    return Observation(None, None, pose, 90.0, positions=seen if positions else None, last_action_succeeded=moved)


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


@pytest.mark.parametrize("yaw, action", [(0.0, Action.STOP), (90.0, Action.ROTATE_LEFT), (270.0, Action.ROTATE_RIGHT)])
def test_it_drives_to_what_moved_and_faces_it(yaw, action):
    first, second = [view(at("k", 3.0, 1.0))], [view(at("other name", 1.0, 3.0))]
    assert driven(first, second, Relation.MOVED, view(x=1.0, z=2.5, yaw=yaw)) == [action]
    assert driven(first, second, Relation.MOVED, view(x=1.0, z=1.0)) == [Action.MOVE_AHEAD]
    assert driven(first, second, Relation.FORMER, view(x=2.5, z=1.0, yaw=90.0)) == [Action.STOP]


def test_it_abstains_where_nothing_is_to_be_found():
    still = [view(at("k", 3.0, 1.0), at("vase", 1.0, 1.0, "Vase"))]
    assert driven(still, still, Relation.MOVED, view()) == [Action.ABSTAIN]
    assert driven(still, still, Relation.MOVING, view()) == [Action.ABSTAIN]


def test_it_follows_the_mover_that_it_chose_while_it_sees_it():
    """Then it goes to where the mover was last recorded."""
    tour = [view(at("still", 0.5, 3.5), at("mover", x, 3.0)) for x in (1.0, 3.5, 2.0)]
    here = {"x": 3.0, "z": 2.5}
    followed = driven(tour, tour, Relation.MOVING, view(at("still", 3.0, 3.0), at("mover", 3.0, 3.0), **here))
    assert followed == [Action.STOP]
    elsewhere = driven(
        tour, tour, Relation.MOVING, view(at("still", 3.0, 3.0), **here), view(at("still", 2.0, 3.0), x=2.0, z=2.5)
    )
    assert elsewhere[0] in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT) and elsewhere[1] is Action.STOP
    assert driven(tour, tour, Relation.STABLE, view(at("still", 3.0, 3.0), x=0.5, z=3.0)) == [Action.STOP]


def test_in_a_corridor_it_waits_for_what_moves_and_gives_up_on_what_stands_still():
    """Something blocks the only way. What moves may go out of it."""
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
