"""Exclusive success: rivals by brute force, at most one right answer per point, and runs that measure the nearest rival."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.interface import Action
from ovman.analysis.outcomes import static_outcomes
from ovman.env import Env, Terms
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.rollouts import rollout_key
from ovman.evaluation.scores import best_stop, is_right, score_rollout
from ovman.generation.certification import TrialRun
from ovman.generation.release import rejection
from ovman.records.episode import Episode
from ovman.records.prediction import Answer, Prediction, UniformPick
from ovman.records.record import RecordError
from ovman.records.task import Instance, Query, Relation, WorldState, rivals
from ovman.records.trial import Certification, Trial, Verdict
from ovman.runner import Run, open_session, replay
from ovman.settings.benchmark import Success
from ovman.settings.splits import Rules
from ovman.task import Measurement, success
from tests.episodes import DATA, episode_record
from tests.runs import job

EXCLUSIVE = Rules(exclusive=True)
CONSTANTS = Success(radius_m=1.0, visible_px=100, sweep_deg=(0, 30, 60))
SEEN = {0: 500, 30: 500, 60: 500}
coordinate = st.integers(-20, 20).map(lambda value: value / 4)
point = st.tuples(coordinate, coordinate)
# What a home has: category, place in visit 1, place in visit 2.
things = st.lists(st.tuples(st.sampled_from("ABC"), st.none() | point, st.none() | point), min_size=1, max_size=7)


def exclusive(episode: Episode) -> Episode:
    return episode.model_copy(update={"rules": EXCLUSIVE})


def released(split: str) -> list[Episode]:
    return [exclusive(one) for one in Episode.load(DATA / "episodes" / f"{split}.jsonl")]


def worlds(home):
    return tuple(
        WorldState(tuple(Instance(str(k), one[0], *one[v]) for k, one in enumerate(home) if one[v] is not None)) for v in (1, 2)
    )


def changes(home):
    changed = [k for k, (_, before, after) in enumerate(home) if before != after]
    return tuple({str(k): home[k][v] for k in changed} for v in (1, 2))


def asked(home) -> list[tuple[Query, str, tuple[float, float]]]:
    """Every query that the changes define, with its target and its answer."""
    found = []
    for k, (category, before, after) in enumerate(home):
        if before is None or after is None:
            relation = Relation.APPEARED if before is None else Relation.REMOVED
            place = before or after
            found += [] if place is None else [(Query(category, relation), str(k), place)]
        elif before == after:
            found.append((Query(category, Relation.STABLE), str(k), after))
        else:
            found += [(Query(category, Relation.MOVED), str(k), after), (Query(category, Relation.FORMER), str(k), before)]
    return found


@given(things, st.integers(0, 6), st.sampled_from(Relation))
def test_rivals_are_every_other_place_of_the_category_and_of_the_changes(home, number, relation):
    target = number % len(home)
    category = home[target][0]
    wanted = set()
    for k, (of, before, after) in enumerate(home):
        for visit, place in ((1, before), (2, after)):
            counts = of == category or before != after
            if k == target:
                counts = (relation, visit) in ((Relation.MOVED, 1), (Relation.FORMER, 2)) and counts
            if place is not None and counts:
                wanted.add(place)
    assert rivals(Query(category, relation), str(target), *worlds(home), changes(home)) == tuple(sorted(wanted))


@given(things, point)
def test_one_point_is_nearest_to_one_answer_alone(home, stop):
    """Of all queries that a home's changes define, about any noun and relation, a stop is right for those of one place."""
    (first, second), queries = worlds(home), asked(home)
    stable = {target: at for query, target, at in queries if query.relation is Relation.STABLE}
    right = {
        at
        for query, target, at in queries
        if all(math.dist(stop, at) < math.dist(stop, r) for r in rivals(query, target, first, second, changes(home), stable))
    }
    assert len(right) <= 1


def test_a_mover_is_a_rival_where_it_is_and_where_it_stood():
    home = [("A", (0.0, 0.0), (1.0, 0.0)), ("B", (5.0, 0.0), (6.0, 0.0))]
    found = rivals(Query("A", Relation.MOVING), "0", *worlds(home), changes(home), {}, {"0": (2.0, 0.0), "1": (3.0, 0.0)})
    assert found == ((3.0, 0.0), (5.0, 0.0))


MEASUREMENT = Measurement(0.5, 0.8, 0.7, SEEN)


@given(st.sampled_from(Relation), st.floats(0, 2), st.floats(0, 2))
def test_success_needs_equation_4_and_the_answer_nearest(relation, answer_m, rival_m):
    measured = replace(MEASUREMENT, answer_distance_m=answer_m, rival_distance_m=rival_m)
    plain = success(measured, relation, CONSTANTS)
    assert success(measured, relation, CONSTANTS, exclusive=True) is (plain and answer_m < rival_m)


def test_exclusive_success_needs_its_measurement():
    with pytest.raises(ValueError, match="make the runs again"):
        success(MEASUREMENT, Relation.MOVED, CONSTANTS, exclusive=True)
    with pytest.raises(ValueError, match="rival_distance_m"):
        replace(MEASUREMENT, rival_distance_m=-0.1)


def chairs(**places):
    return [{"id": name, "category": "Chair", "x": x, "z": z} for name, (x, z) in places.items()]


def test_a_prediction_between_two_instances_is_right_for_one_of_them():
    record = episode_record("moved", answer=(1.0, 0.0), world=chairs(a=(1.0, 0.0), b=(2.0, 0.0)))
    plain = Episode.from_json(record)
    case = Episode.from_json(record | {"rules": {"exclusive": True}})
    assert plain.rivals() == () and (2.0, 0.0) in case.rivals()
    (between,) = [Prediction.of(case.id, "arm", 0, Answer(1.6, 0.0))]
    assert [static_outcomes([one], [between], radius_m=1.0)[0].success for one in (plain, case)] == [1.0, 0.0]
    pick = Prediction.of(case.id, "arm", 0, UniformPick(((1.4, 0.0), (1.6, 0.0))))
    assert [static_outcomes([one], [pick], radius_m=1.0)[0].success for one in (plain, case)] == [1.0, 0.5]


def test_rules_of_the_paper_are_not_written(tmp_path):
    record = episode_record("moved") | {"rules": {}}
    assert "rules" not in Episode.from_json(record).to_json()
    assert exclusive(Episode.from_json(record)).to_json()["rules"]["exclusive"] is True
    with pytest.raises(RecordError, match="rules"):
        Episode.from_json(record | {"rules": {"exclusive": "yes"}})


def pairs_of(episodes):
    def key(one):
        return one.scene, one.visits.first, one.visits.second

    return [list(group) for _, group in groupby(sorted(episodes, key=key), key=key)]


def test_the_best_fixed_answer_is_right_once_per_place():
    """Queries of one world pair: with rivals the best point serves one answer, without them it may serve several."""
    several = [group for group in pairs_of(released("multi")) if len({one.answer for one in group}) > 1]
    assert several
    for group in several:
        most = max(Counter(one.answer for one in group).values())
        for radius_m in (1.0, math.inf):
            at, share = best_stop(group, radius_m)
            assert share == most / len(group)
            assert sum(is_right(at, one, radius_m) for one in group) == most


def test_without_rivals_one_stop_serves_two_answers():
    world = chairs(a=(0.0, 0.0), b=(1.5, 0.0))
    one = Episode.from_json(episode_record("moved", answer=(0.0, 0.0), world=world))
    record = episode_record("moved", 1, answer=(1.5, 0.0), world=world)
    other = Episode.from_json(record | {"target": "b", "changes": [{**record["changes"][0], "instance": "b"}]})
    assert best_stop([one, other], 1.0)[1] == 1.0
    assert best_stop([exclusive(one), exclusive(other)], 1.0)[1] == 0.5


def test_a_trial_and_its_episode_have_the_same_rivals():
    trials = {trial.candidate.id: trial for trial in Trial.read(DATA / "trials" / "dev_everyday.jsonl")}
    episodes = released("dev_everyday")
    for episode in episodes:
        trial = trials[episode.id]
        assert TrialRun.of(trial).rivals() == episode.rivals() != ()
        candidate = trial.candidate.model_copy(update={"rules": Rules()})
        assert TrialRun.of(trial.model_copy(update={"candidate": candidate})).rivals() == ()


def moving_with_two() -> Episode:
    return next(one for one in released("dev_everyday") if one.relation is Relation.MOVING and len(one.movers) > 1)


def test_a_run_measures_the_nearest_rival_where_the_movers_are_at_the_stop():
    episode, (arm, settings) = moving_with_two(), job("oracle_check")
    other = next(mover.instance for mover in episode.movers if mover.instance != episode.target)
    run = Run(episode, arm, 0, settings)
    with open_session(episode, arm, settings) as session:
        env = Env(session, episode.settings)
        seen = []
        for actions in (1, 40):
            env.reset(episode, Terms(np.random.default_rng(0)), looks=False)
            for _ in range(actions):
                env.step(Action.ROTATE_LEFT)
            here = {k: mover.position for k, mover in env._world.movers.items()}
            stop = session.pose.x, session.pose.z
            env.step(Action.STOP)
            wanted = min(math.dist(stop, rival) for rival in episode.rivals(here))
            assert env.measured.rival_distance_m == pytest.approx(wanted, abs=1e-4)
            assert here[other] in episode.rivals(here) and here[episode.target] not in episode.rivals(here)
            seen.append(here[other])
        assert seen[0] != seen[1]
        plain = replay(session, replace(run, episode=episode.model_copy(update={"rules": Rules()})), "S")
        assert "rival_distance_m" not in plain.to_json()
        again = replay(session, run, "S")
        assert again.rival_distance_m is not None and score_rollout(again, episode).rival_distance_m == again.rival_distance_m
        with pytest.raises(ValueError, match="make the runs again"):
            score_rollout(plain, episode)


def test_certification_judges_by_the_rules_of_the_candidate():
    certified = {record.id: record.runs for record in Certification.read(DATA / "certified" / "dev.jsonl")}
    episode = Episode.load(DATA / "episodes" / "dev.jsonl")[0]
    verdict = Verdict(id=episode.id, relation=episode.relation, rejected=None, reasons=())
    runs = certified[verdict.id]
    assert rejection(verdict, runs, CONSTANTS) is None
    far, near = ([run.model_copy(update={"rival_distance_m": metres}) for run in runs] for metres in (9.0, 0.0))
    assert rejection(verdict, far, CONSTANTS, exclusive=True) is None
    assert rejection(verdict, near, CONSTANTS, exclusive=True) is not None


def test_a_kept_run_depends_on_what_its_rivals_are(tmp_path):
    """World states judge a run of the paper's protocol. They are measured in a run whose success is exclusive."""
    (arm, settings), episode = job("oracle_check"), released("main")[0]
    store = ObservationStore(arm, settings, 90.0, tmp_path)

    def key(rules: Rules, world: WorldState) -> str:
        return rollout_key(Run(episode.model_copy(update={"rules": rules, "world_2": world}), arm, 0, settings, store))

    world = episode.world_2
    other = WorldState((*world, Instance("another", episode.category, 9.0, 9.0)))
    assert key(Rules(), world) == key(Rules(), other)
    assert key(EXCLUSIVE, world) != key(EXCLUSIVE, other)
