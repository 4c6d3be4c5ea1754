"""World pairs: crossed queries by brute force, a pair drawn in a home, and the bounds on all released pairs."""

from __future__ import annotations

import csv
import math
from collections import Counter, defaultdict
from itertools import chain, combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.evaluation.scores import best_stop
from ovman.generation.crossed import FEWEST, draw_candidates, limit, prune
from ovman.generation.drawing import Drawing
from ovman.generation.release import run
from ovman.generation.scenes import draw_homes, survey_with_movers
from ovman.generation.verdict import verdict
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.scene import Scene
from ovman.records.task import Query, Rejection, Relation
from ovman.records.trial import Trial
from ovman.settings.config import load
from ovman.shipped import EMBEDDED
from ovman.sim.session import Session
from tests.shared import made_once
from tests.test_config import changed

SETTINGS = load(changed({}))
SPLIT = SETTINGS.splits["dev_everyday"]
QUERIES = st.frozensets(st.builds(Query, st.sampled_from("abcd"), st.sampled_from(list(Relation)[:4])), max_size=8)


def is_crossed(queries) -> bool:
    """Return whether every relation has two nouns or more, and every noun two relations or more."""
    nouns, relations = defaultdict(set), defaultdict(set)
    for query in queries:
        nouns[query.relation].add(query.category)
        relations[query.category].add(query.relation)
    return all(len(found) >= FEWEST for found in chain(nouns.values(), relations.values()))


@given(QUERIES)
def test_pruning_keeps_the_union_of_all_crossed_subsets(queries):
    subsets = chain.from_iterable(combinations(queries, k) for k in range(len(queries) + 1))
    assert prune(queries) == frozenset(chain.from_iterable(filter(is_crossed, subsets)))


@given(QUERIES, st.integers(1, 8))
def test_a_limited_set_is_crossed_and_small_enough(queries, most):
    kept = limit(queries, most)
    assert kept <= queries and len(kept) <= most and is_crossed(kept)
    assert len(prune(queries)) > most or kept == prune(queries)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A home of the split that develops agents."""

    def make(root):
        root.mkdir()
        (name,) = draw_homes(SPLIT.homes.model_copy(update={"seed": 5, "count": 1}))
        with Session(name, SETTINGS) as session:
            (root / "scene.jsonl").write_text(survey_with_movers(session, SETTINGS).to_line())

    return Scene.read(made_once(tmp_path_factory, "crossed", make) / "scene.jsonl")[0]


@pytest.fixture(scope="module")
def drawn(scene):
    return draw_candidates(scene, Drawing.of(SPLIT, scene, SETTINGS), SETTINGS)


def test_candidates_of_a_pair_differ_in_their_query_alone(drawn):
    assert len(drawn) >= SPLIT.crossed.queries[0]
    shared = {(one.pair, one.first, one.second, one.tours.model_dump_json(), one.spawn, one.scene) for one in drawn}
    assert len(shared) == 1
    assert is_crossed({Query(one.category, one.relation) for one in drawn})
    assert len({one.id for one in drawn}) == len({(one.category, one.relation) for one in drawn}) == len(drawn)


def test_every_query_has_one_referent_and_two_instances_to_choose_from(scene, drawn):
    category = {item.id: item.category for item in scene.objects}
    for one in drawn:
        gone = [{made.instance for made in visit if made.kind == "disable"} for visit in (one.first, one.second)]
        moved, moving = ({a.instance for a in one.second if a.kind == kind} for kind in ("displace", "motion"))
        holding = {
            Relation.APPEARED: gone[0],
            Relation.REMOVED: gone[1],
            Relation.MOVED: moved,
            Relation.FORMER: moved,
            Relation.MOVING: moving,
            Relation.STABLE: set(category) - gone[0] - gone[1] - moved - moving,
        }[one.relation]
        assert [k for k in holding if category[k] == one.category] == [one.target]
        there = [k for k in category if category[k] == one.category and k not in gone[int(not one.relation.past)]]
        assert len(there) >= FEWEST


def test_no_place_of_a_pair_is_at_the_spawn_or_near_a_waypoint(scene, drawn):
    one = drawn[0]
    by_id = {item.id: item for item in scene.objects}
    places = [by_id[made.instance].place for made in one.first + one.second]
    places += [made.placement for made in one.second if made.placement is not None]
    clearance_m = SETTINGS.candidates.spawn_clearance_m
    assert all(math.dist(place, (one.spawn.x, one.spawn.z)) >= clearance_m for place in places)
    for made in one.second:
        if made.placement is not None:
            spare = by_id[made.instance].spare
            assert made.placement == (spare.x, spare.z) and made.yaw_deg == spare.yaw_deg


def test_a_pair_is_drawn_again_to_the_same_bytes(scene, drawn):
    again = draw_candidates(scene, Drawing.of(SPLIT, scene, SETTINGS), SETTINGS)
    assert [one.to_line() for one in again] == [one.to_line() for one in drawn]


@pytest.mark.parametrize("split", ["everyday", "dev_everyday"])
def test_no_fixed_answer_is_right_for_two_queries_of_a_relation_or_of_a_noun(split):
    groups = defaultdict(list)
    for episode in Episode.load(EMBEDDED / "episodes" / f"{split}.jsonl"):
        groups[episode.pair, episode.relation].append(episode)
        groups[episode.pair, episode.category].append(episode)
    assert groups and None not in {pair for pair, _ in groups}
    for name, group in groups.items():
        _, share = best_stop(group)
        assert len(group) >= FEWEST and share <= 1 / len(group) + 1e-9, name


def lack_a_query(pairs, fewest):
    """Return the ids of a pair's queries without one query, after which some others are not crossed, and those that are."""
    for ids in pairs.values():
        for dropped in ids:
            left = {query: name for query, name in ids.items() if query != dropped}
            if fewest <= len(prune(left)) < len(left):
                return left, prune(left)
    raise AssertionError("no pair loses a second query with a first one")


def test_the_audit_counts_certified_trials_that_their_pair_leaves_out(tmp_path):
    split, pairs = "dev_everyday", defaultdict(dict)
    for episode in Episode.load(EMBEDDED / "episodes" / f"{split}.jsonl"):
        pairs[episode.pair][Query(episode.category, episode.relation)] = episode.id
    left, crossed = lack_a_query(pairs, SPLIT.crossed.queries[0])
    drawn = [one for one in Trial.read(EMBEDDED / "trials" / f"{split}.jsonl") if one.candidate.id in left.values()]
    trials, verdicts, *outputs = (tmp_path / name for name in ("trials", "verdicts", "episodes", "sightings", "audit"))
    trials.write_text(lines(drawn))
    verdicts.write_text(lines(verdict(one, SETTINGS) for one in drawn))
    run(trials, verdicts, EMBEDDED / "certified" / f"{split}.jsonl", SETTINGS, *outputs, split)
    assert {one.id for one in Episode.load(outputs[0])} == {left[query] for query in crossed}
    with outputs[2].open(newline="") as file:
        counted = {row["relation"]: int(row["count"]) for row in csv.DictReader(file) if row["reason"] == Rejection.NOT_CROSSED}
    assert counted == Counter(query.relation for query in left.keys() - crossed)
