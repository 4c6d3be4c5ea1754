"""Eq. 1 to 3: which instances a query selects, whether it may be released, and where it is answered."""

from __future__ import annotations

import math

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


def mapped(world, place):
    """A world state under a map of the floor plane."""
    return WorldState(tuple(Instance(i.id, i.category, *place(i.x, i.z), tuple(place(x, z) for x, z in i.track)) for i in world))


def all_referents(world_1, world_2, constants=CONSTANTS):
    queries = [Query(category, relation) for category in ("Chair", "Vase") for relation in Relation]
    return {query: referents(world_1, world_2, query, constants) for query in queries}


def home(**positions):
    return WorldState(tuple(Instance(name, CATEGORIES[name], *point) for name, point in positions.items()))


# --- Eq. 1 ----------------------------------------------------------------------------------------


def holds_by_hand(relation, name, world_1, world_2):
    """Eq. 1 on squared distances, which are exact for these coordinates."""
    before, after = ({one.id: one for one in world} for world in (world_1, world_2))
    moved = {k: (before[k].x - after[k].x) ** 2 + (before[k].z - after[k].z) ** 2 for k in before.keys() & after.keys()}
    like = [k for k in after if CATEGORIES.get(k) == CATEGORIES.get(name) and k != name]
    return {
        Relation.MOVED: moved.get(name, 0.0) >= 1.5**2,
        Relation.FORMER: moved.get(name, 0.0) >= 1.5**2,
        Relation.STABLE: moved.get(name, 9.0) < 0.75**2 and any(moved.get(k, 0.0) >= 1.5**2 for k in like),
        Relation.MOVING: name in after and any(math.dist(a, b) > 0.01 for a in after[name].track for b in after[name].track),
        Relation.APPEARED: name in after and name not in before,
        Relation.REMOVED: name in before and name not in after,
    }[relation]


@given(worlds(), RELATIONS)
def test_each_relation_holds_where_it_does_by_hand(pair, relation):
    """At the thresholds, too: of 0.75 m and 1.5 m, displacements have exact values here."""
    for name in (*CATEGORIES, "nobody"):
        assert holds(relation, name, *pair, CONSTANTS) == holds_by_hand(relation, name, *pair)
    chairs = tuple(k for k in CATEGORIES if CATEGORIES[k] == "Chair" and holds_by_hand(relation, k, *pair))
    assert referents(*pair, CHAIR[relation], CONSTANTS) == chairs


@pytest.mark.parametrize("metres", [1.5, 1.25, 0.75, 0.5])
def test_the_thresholds_are_inclusive_for_moved_and_exclusive_for_stable(metres):
    before, after = home(chair_1=(0, 0), chair_2=(3, 0)), home(chair_1=(0.0, metres), chair_2=(5, 0))
    assert holds(Relation.MOVED, "chair_1", before, after, CONSTANTS) == (metres >= 1.5)
    assert holds(Relation.STABLE, "chair_1", before, after, CONSTANTS) == (metres < 0.75)


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


# --- Eq. 2 ----------------------------------------------------------------------------------------


@given(worlds(), RELATIONS, st.sets(st.sampled_from(sorted(CATEGORIES))), st.sampled_from([None, *sorted(CATEGORIES)]))
def test_a_query_is_admissible_where_it_is_by_hand(pair, relation, changed, target):
    selected = tuple(k for k in CATEGORIES if CATEGORIES[k] == "Chair" and holds_by_hand(relation, k, *pair))
    shoved = tuple(
        sorted(
            one.id
            for one in pair[0].category("Chair")
            if one.id not in {*selected, *changed} and one.id in pair[1]
            if (one.x - pair[1][one.id].x) ** 2 + (one.z - pair[1][one.id].z) ** 2 > 0.75**2
        )
    )
    expected = Inadmissible(Rejection.BYSTANDER_MOVED, shoved) if shoved else None
    if len(selected) != 1:
        expected = Inadmissible(Rejection.REFERENT_AMBIGUOUS if selected else Rejection.REFERENT_ABSENT, selected)
    elif target not in (None, *selected):
        expected = Inadmissible(Rejection.REFERENT_NOT_TARGET, selected)
    assert admissible(*pair, CHAIR[relation], changed, CONSTANTS, target) == expected


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
