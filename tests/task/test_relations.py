"""Eq. 1 to 3: which instances a query selects, whether it may be released, and where it is answered."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ovman.records.scene import MoverRecord
from ovman.settings import Settings
from ovman.task import (
    Inadmissible,
    Instance,
    Query,
    Rejection,
    Relation,
    WorldState,
    admissible,
    answer,
    displacement_m,
    holds,
    referents,
    true_world,
)


def thresholds(delta_min_m: float = 1.5, tau_m: float = 0.75, motion_m: float = 0.01) -> Settings:
    """The constants of Eq. 1 and 2, and no others."""
    return Settings.partial(
        {"candidates": {"delta_min_m": delta_min_m}, "admissibility": {"tau_m": tau_m, "motion_m": motion_m}}, "tests"
    )


CONSTANTS = thresholds()
CATEGORIES = {"chair_1": "Chair", "chair_2": "Chair", "chair_3": "Chair", "vase_1": "Vase", "vase_2": "Vase"}
CHAIR = {relation: Query("Chair", relation) for relation in Relation}
RELATIONS = st.sampled_from(Relation)

# Multiples of 0.25 m: their sums and right-angle turns are exact, and distances fall on the thresholds themselves.
COORDINATES = st.integers(-12, 12).map(lambda quarter: quarter * 0.25)
POINTS = st.tuples(COORDINATES, COORDINATES)


@st.composite
def worlds(draw, moving=True):
    """Two states of one home. Most instances are present in both, half of those where they were."""
    states = ([], [])
    for name, category in CATEGORIES.items():
        presence = draw(st.sampled_from(["both", "both", "both", "first", "second", "neither"]))
        before = draw(POINTS)
        after = draw(st.one_of(st.just(before), POINTS))
        track = (*draw(st.lists(POINTS, max_size=2)), after) if moving and draw(st.booleans()) else ()
        if presence in ("both", "first"):
            states[0].append(Instance(name, category, *before))
        if presence in ("both", "second"):
            states[1].append(Instance(name, category, *after, track))
    return WorldState(tuple(states[0])), WorldState(tuple(draw(st.permutations(states[1]))))


def mapped(world, place=lambda x, z: (x, z), name=lambda k: k):
    """A world state under a map of the floor plane and of the names."""
    return WorldState(
        tuple(Instance(name(i.id), i.category, *place(i.x, i.z), tuple(place(x, z) for x, z in i.track)) for i in world)
    )


def all_referents(world_1, world_2, constants=CONSTANTS):
    queries = [Query(category, relation) for category in ("Chair", "Vase") for relation in Relation]
    return {query: referents(world_1, world_2, query, constants) for query in queries}


def home(**positions):
    return WorldState(tuple(Instance(name, CATEGORIES[name], *point) for name, point in positions.items()))


# --- Relation -------------------------------------------------------------------------------------


# --- Eq. 1 ----------------------------------------------------------------------------------------


@given(worlds())
def test_moved_and_former_share_a_predicate(pair):
    assert referents(*pair, CHAIR[Relation.MOVED], CONSTANTS) == referents(*pair, CHAIR[Relation.FORMER], CONSTANTS)


@given(worlds(), RELATIONS)
def test_no_relation_holds_for_an_absent_instance(pair, relation):
    assert not holds(relation, "nobody", *pair, CONSTANTS)
    for name in CATEGORIES:
        if holds(relation, name, *pair, CONSTANTS):
            answering = pair[0] if relation.past else pair[1]
            assert name in answering
            if relation in (Relation.MOVED, Relation.FORMER, Relation.STABLE):
                assert name in pair[0] and name in pair[1]


@given(worlds())
def test_stable_moved_appeared_and_removed_exclude_each_other(pair):
    for name in CATEGORIES:
        exclusive = (Relation.STABLE, Relation.MOVED, Relation.APPEARED, Relation.REMOVED)
        assert sum(holds(relation, name, *pair, CONSTANTS) for relation in exclusive) <= 1


@given(worlds())
def test_every_instance_present_in_one_visit_only_has_appeared_or_was_removed(pair):
    world_1, world_2 = pair
    both_categories = [
        set(referents(*pair, Query("Chair", relation), CONSTANTS)) | set(referents(*pair, Query("Vase", relation), CONSTANTS))
        for relation in (Relation.APPEARED, Relation.REMOVED)
    ]
    assert both_categories == [world_2.ids - world_1.ids, world_1.ids - world_2.ids]


@given(worlds())
def test_appeared_and_removed_swap_when_the_visits_swap(pair):
    forwards, backwards = all_referents(*pair), all_referents(*reversed(pair))
    for category in ("Chair", "Vase"):
        for there, back in (
            (Relation.APPEARED, Relation.REMOVED),
            (Relation.REMOVED, Relation.APPEARED),
            (Relation.MOVED, Relation.MOVED),
            (Relation.STABLE, Relation.STABLE),
        ):
            assert forwards[Query(category, there)] == backwards[Query(category, back)]


@given(worlds(), st.floats(0.0, 2.0 * math.pi))
def test_relations_are_invariant_under_any_rotation(pair, angle):
    def place(x, z):
        return math.cos(angle) * x - math.sin(angle) * z, math.sin(angle) * x + math.cos(angle) * z

    # A displacement on a threshold is decided by the last bit of the rotation.
    displacements = [d for name in CATEGORIES if (d := displacement_m(*pair, name)) is not None]
    assume(
        all(
            abs(d - threshold) > 1e-9
            for d in displacements
            for threshold in (CONSTANTS.admissibility.tau_m, CONSTANTS.candidates.delta_min_m)
        )
    )
    assert all_referents(*(mapped(world, place) for world in pair)) == all_referents(*pair)


@given(worlds(), st.permutations(sorted(CATEGORIES)))
def test_relations_are_equivariant_under_relabelling(pair, names):
    relabelled = dict(zip(sorted(CATEGORIES), names, strict=True))
    renamed = all_referents(*(mapped(world, name=relabelled.__getitem__) for world in pair))
    assert renamed == {q: tuple(sorted(relabelled[k] for k in ids)) for q, ids in all_referents(*pair).items()}


@given(worlds(), RELATIONS)
def test_other_categories_have_no_say(pair, relation):
    chairs = [WorldState(world.category("Chair")) for world in pair]
    assert referents(*pair, CHAIR[relation], CONSTANTS) == referents(*chairs, CHAIR[relation], CONSTANTS)


@given(worlds(), st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_a_larger_minimum_displacement_selects_fewer_and_a_larger_tau_more(pair, a, b):
    small, large = sorted((a, b))
    for relation, field, fewer, more in (
        (Relation.MOVED, "delta_min_m", large, small),
        (Relation.STABLE, "delta_min_m", large, small),
        (Relation.STABLE, "tau_m", small, large),
        (Relation.MOVING, "motion_m", large, small),
    ):
        selected = [set(referents(*pair, CHAIR[relation], thresholds(**{field: value}))) for value in (fewer, more)]
        assert selected[0] <= selected[1]


@given(worlds(moving=False))
def test_nothing_is_moving_without_a_track_and_nothing_else_reads_one(pair):
    assert referents(*pair, CHAIR[Relation.MOVING], CONSTANTS) == ()
    still = WorldState(tuple(replace(i, track=((i.x, i.z),) * 3) for i in pair[1]))
    assert all_referents(pair[0], still) == all_referents(*pair)


@given(worlds(), st.randoms(use_true_random=False))
def test_motion_does_not_depend_on_the_order_of_the_track(pair, random):
    def shuffled(instance):
        track = list(instance.track)
        random.shuffle(track)
        return Instance.tracked(instance.id, instance.category, tuple(track)) if track else instance

    mixed = WorldState(tuple(shuffled(i) for i in pair[1]))
    query = CHAIR[Relation.MOVING]
    assert referents(pair[0], mixed, query, CONSTANTS) == referents(*pair, query, CONSTANTS)


def test_the_thresholds_are_inclusive_for_moved_and_exclusive_for_stable():
    before = home(chair_1=(0, 0), chair_2=(3, 0))
    for displacement, relation, expected in (
        (1.5, Relation.MOVED, ("chair_2",)),
        (1.49, Relation.MOVED, ()),
        (1.5, Relation.STABLE, ("chair_1",)),
        (1.49, Relation.STABLE, ()),
    ):
        after = home(chair_1=(0, 0), chair_2=(3 + displacement, 0))
        assert referents(before, after, CHAIR[relation], CONSTANTS) == expected
    after = home(chair_1=(0.75, 0), chair_2=(5, 0))
    assert referents(before, after, CHAIR[Relation.STABLE], CONSTANTS) == ()


def test_stable_needs_another_instance_of_the_category_that_moved():
    before = home(chair_1=(0, 0), vase_1=(0, 2), chair_2=(3, 0))
    assert referents(before, before, CHAIR[Relation.STABLE], CONSTANTS) == ()
    assert referents(before, home(chair_1=(0, 0), vase_1=(3, 2), chair_2=(3, 0)), CHAIR[Relation.STABLE], CONSTANTS) == ()
    assert referents(before, home(chair_1=(0, 0), vase_1=(0, 2)), CHAIR[Relation.STABLE], CONSTANTS) == ()
    moved = home(chair_1=(0, 0), vase_1=(0, 2), chair_2=(3, 2))
    assert referents(before, moved, CHAIR[Relation.STABLE], CONSTANTS) == ("chair_1",)


def test_a_mover_counts_as_moving_though_it_comes_back_and_even_if_it_is_new():
    track = ((0.0, 0.0), (0.3, 0.0), (0.0, 0.0))
    mover = Instance.tracked("chair_1", "Chair", track)
    assert mover.extent_m == pytest.approx(0.3)
    for before in (home(chair_1=(0, 0)), WorldState(())):
        assert referents(before, WorldState((mover,)), CHAIR[Relation.MOVING], CONSTANTS) == ("chair_1",)
    jitter = Instance.tracked("chair_1", "Chair", ((0.0, 0.0), (0.01, 0.0)))
    assert referents(home(chair_1=(0, 0)), WorldState((jitter,)), CHAIR[Relation.MOVING], CONSTANTS) == ()


# --- Eq. 2 ----------------------------------------------------------------------------------------


@given(worlds(), RELATIONS, st.sets(st.sampled_from(sorted(CATEGORIES))))
def test_an_admissible_query_has_exactly_one_referent_and_an_answer(pair, relation, changed):
    query = CHAIR[relation]
    selected = referents(*pair, query, CONSTANTS)
    verdict = admissible(*pair, query, changed, CONSTANTS)
    if verdict is None:
        (referent,) = selected
        answering = pair[0] if relation.past else pair[1]
        assert answer(*pair, query, referent) == answering[referent].position
    elif verdict.reason is Rejection.REFERENT_ABSENT:
        assert selected == verdict.instances == ()
    elif verdict.reason is Rejection.REFERENT_AMBIGUOUS:
        assert len(selected) > 1 and verdict.instances == selected
    else:
        assert verdict.reason is Rejection.BYSTANDER_MOVED and len(selected) == 1
        assert verdict.instances and not set(verdict.instances) & (set(selected) | changed)
        assert all(displacement_m(*pair, k) > CONSTANTS.admissibility.tau_m for k in verdict.instances)


@given(worlds(), RELATIONS, st.sets(st.sampled_from(sorted(CATEGORIES))), st.sampled_from(sorted(CATEGORIES)))
def test_excusing_one_more_instance_never_makes_a_query_inadmissible(pair, relation, changed, another):
    if admissible(*pair, CHAIR[relation], changed, CONSTANTS) is None:
        assert admissible(*pair, CHAIR[relation], changed | {another}, CONSTANTS) is None


@given(worlds(), RELATIONS, st.sampled_from(sorted(CATEGORIES)))
def test_naming_a_target_admits_the_query_for_the_referent_alone(pair, relation, target):
    query, changed = CHAIR[relation], {"chair_1", "chair_2"}
    without, named = (admissible(*pair, query, changed, CONSTANTS, target=t) for t in (None, target))
    if named is None:
        assert without is None and referents(*pair, query, CONSTANTS) == (target,)
    elif named.reason is Rejection.REFERENT_NOT_TARGET:
        assert target not in named.instances and named.instances == referents(*pair, query, CONSTANTS)
    else:
        assert named == without


def test_a_bystander_that_was_shoved_spoils_the_query():
    before = home(chair_1=(0, 0), chair_2=(3, 0), vase_1=(0, 3))
    after = home(chair_1=(0, 2), chair_2=(3, 0.76), vase_1=(3, 3))
    query = CHAIR[Relation.MOVED]
    assert admissible(before, after, query, {"chair_1"}, CONSTANTS) == Inadmissible(Rejection.BYSTANDER_MOVED, ("chair_2",))
    assert admissible(before, after, query, {"chair_1"}, thresholds(tau_m=0.76)) is None


def test_the_distractor_of_stable_has_to_move_and_is_excused():
    before = home(chair_1=(0, 0), chair_2=(3, 0))
    after = home(chair_1=(0, 0), chair_2=(3, 2))
    query = CHAIR[Relation.STABLE]
    assert admissible(before, after, query, {"chair_2"}, CONSTANTS, target="chair_1") is None
    assert admissible(before, after, query, frozenset(), CONSTANTS) == Inadmissible(Rejection.BYSTANDER_MOVED, ("chair_2",))


def test_two_movers_are_ambiguous_and_an_unscripted_one_is_not_the_target():
    before = home(chair_1=(0, 0), chair_2=(3, 0))
    both = home(chair_1=(0, 2), chair_2=(3, 2))
    query = CHAIR[Relation.FORMER]
    verdict = admissible(before, both, query, {"chair_1"}, CONSTANTS)
    assert verdict == Inadmissible(Rejection.REFERENT_AMBIGUOUS, ("chair_1", "chair_2"))
    only = home(chair_1=(0, 0), chair_2=(3, 2))
    verdict = admissible(before, only, query, {"chair_1"}, CONSTANTS, target="chair_1")
    assert verdict == Inadmissible(Rejection.REFERENT_NOT_TARGET, ("chair_2",))


# --- Eq. 3 ----------------------------------------------------------------------------------------


def test_moved_and_former_answer_with_the_two_ends_of_one_displacement():
    before, after = home(chair_1=(0, 0), chair_2=(3, 0)), home(chair_1=(0, 2), chair_2=(3, 0))
    assert answer(before, after, CHAIR[Relation.MOVED], "chair_1") == (0, 2)
    assert answer(before, after, CHAIR[Relation.FORMER], "chair_1") == (0, 0)


@given(worlds(), POINTS, RELATIONS)
def test_only_moving_follows_the_mover(pair, mover_at, relation):
    for referent in referents(*pair, CHAIR[relation], CONSTANTS):
        fixed, followed = (answer(*pair, CHAIR[relation], referent, mover_at=at) for at in (None, mover_at))
        assert followed == (mover_at if relation is Relation.MOVING else fixed)


def test_a_past_relation_has_no_answer_where_the_instance_was_not():
    with pytest.raises(KeyError, match="chair_2 is absent"):
        answer(home(chair_1=(0, 0)), home(chair_2=(0, 0)), CHAIR[Relation.REMOVED], "chair_2")


# --- world states ---------------------------------------------------------------------------------


def test_an_instance_is_where_its_track_ends():
    with pytest.raises(ValueError, match="its track ends at"):
        Instance("chair_1", "Chair", 0.0, 0.0, ((0.0, 0.0), (1.0, 0.0)))
    assert Instance.tracked("chair_1", "Chair", ((0.0, 0.0), (1.0, 0.0))).position == (1.0, 0.0)


# --- world states of a tour -----------------------------------------------------------------------


def test_the_true_state_has_the_whole_path_of_each_mover_and_leaves_the_others_as_they_are():
    path = ((0.0, 0.0), (0.0, 0.25), (0.25, 0.25))
    mover = MoverRecord(instance="chair_1", position=path[-1], heading_deg=90, path=path)
    world = WorldState((Instance("chair_1", "Chair", *path[-1]), Instance("chair_2", "Chair", 2.0, 1.0)))
    assert true_world(world, (mover,)) == WorldState(
        (Instance("chair_1", "Chair", 0.25, 0.25, path), Instance("chair_2", "Chair", 2.0, 1.0))
    )
    assert true_world(world, ()) == world
