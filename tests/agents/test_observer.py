"""The ideal observer: it needs looks and places, never who is who, and on queries that these decide it is always right."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.interface import Answer, Query, Relation, UniformPick
from ovman.agents.observer import Seen, find_places, match, predict
from ovman.evaluation.true_grounding import read_looks
from ovman.records.scene import Scene
from ovman.records.task import Instance, WorldState
from ovman.records.visit import Sightings
from ovman.task import recorded_world
from tests.arms import CONFIG
from tests.episodes import DATA, released

LIMITS = CONFIG.admissibility.tau_m, CONFIG.admissibility.motion_m


def world(**places):
    """Chairs by their names: where they are, or their tracks."""
    tracks = {name: (at,) if isinstance(at[0], (int, float)) else at for name, at in places.items()}
    return WorldState(tuple(Instance.tracked(name, "Chair", track) for name, track in tracks.items()))


def told(first, second, looks):
    worlds = {"first": first, "second": second}
    return SimpleNamespace(world=worlds.__getitem__, looks=looks, settings=CONFIG)


def crossed(rng):
    """A pair of visits in which one chair moved, one went, one came, one moves and one stayed, all of different looks."""
    spots = [(2.0 * x, 2.0 * z) for x in range(4) for z in range(3)]
    at = [spots[k] for k in rng.permutation(len(spots))]
    names = [f"Chair|{k}" for k in rng.permutation(9)]
    moved, gone, come, mover, stays = names[:5]
    walk = tuple((at[5][0] + 0.2 * k, at[5][1]) for k in range(int(rng.integers(2, 12))))
    first = world(**{moved: at[0], gone: at[1], stays: at[2], mover: at[3]})
    # The place that one of them left may be taken by another.
    taken = at[0] if rng.random() < 0.5 else at[6]
    second = world(**{moved: at[4], come: taken, stays: at[2], mover: walk})
    answers = {"moved": at[4], "former": at[0], "moving": walk[-1], "stable": at[2], "appeared": taken, "removed": at[1]}
    return first, second, {name: f"look {k}" for k, name in enumerate(names)}, answers


@pytest.mark.parametrize("seed", range(40))
def test_it_answers_every_query_that_looks_and_places_decide(seed):
    first, second, looks, answers = crossed(np.random.default_rng(seed))
    for relation in Relation:
        assert predict(Query("Chair", relation), told(first, second, looks))[0] == Answer(*answers[relation])


@pytest.mark.parametrize("relation", Relation)
def test_names_and_their_order_change_nothing(relation):
    first, second, looks, _ = crossed(np.random.default_rng(7))
    expected = predict(Query("Chair", relation), told(first, second, looks))[0]
    other = {name: f"other {name}" for name in second.ids}
    renamed = WorldState(tuple(Instance.tracked(other[one.id], "Chair", one.track) for one in reversed(second.instances)))
    known = looks | {other[name]: looks[name] for name in second.ids}
    assert predict(Query("Chair", relation), told(first, renamed, known))[0] == expected


def test_of_equal_looks_the_one_at_its_place_stayed_and_what_is_left_moved():
    first = [Seen("oak", ((0.0, 0.0),)), Seen("oak", ((4.0, 0.0),))]
    second = [Seen("oak", ((4.0, 0.1),)), Seen("oak", ((8.0, 0.0),))]
    assert sorted(match(first, second, LIMITS[0])) == [(0, 1), (1, 0)]
    assert find_places(Relation.FORMER, first, second, *LIMITS) == [(0.0, 0.0)]
    assert find_places(Relation.STABLE, first, second, *LIMITS) == [(4.0, 0.1)]


def test_where_looks_leave_a_choice_it_picks_among_what_is_left():
    first, second = world(a=(0.0, 0.0), b=(3.0, 0.0)), world(c=(6.0, 0.0), d=(9.0, 0.0))
    equal = dict.fromkeys("abcd", "oak")
    assert predict(Query("Chair", Relation.REMOVED), told(first, second, equal))[0] == UniformPick(((0.0, 0.0), (3.0, 0.0)))
    left, right = ([Seen(one.id, one.track) for one in instances] for instances in (first, second))
    assert find_places(Relation.MOVED, left, right, *LIMITS) == [(6.0, 0.0), (9.0, 0.0)]


def test_on_the_released_split_where_one_instance_changes_it_is_always_right():
    scenes = {scene.scene: scene for scene in Scene.read(DATA / "scenes" / "main.jsonl")}
    seen = {record.episode: record.sightings for record in Sightings.read(DATA / "sightings" / "main.jsonl")}
    for episode in released():
        looks = read_looks(scenes[episode.scene])
        worlds = [recorded_world(seen[episode.id][which], episode.category, 300) for which in ("first", "second")]
        found = predict(episode.query, told(*worlds, looks))[0]
        assert isinstance(found, Answer) and math.dist((found.x, found.z), episode.answer) <= CONFIG.success.radius_m
