"""Admissibility under other thresholds: whom each setting admits, and the margins over whom it admits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.probes import compute_margins
from ovman.generation.readmission import admitting, settings_of
from ovman.generation.verdict import reasons
from ovman.records.geometry import Spawn
from ovman.records.scene import Alteration
from ovman.records.task import Instance, Rejection, Relation, WorldState
from ovman.records.tour import Tour
from ovman.records.trial import Admission, Candidate, Trial, TrialMeasurement
from ovman.records.visit import Sighting, VisitPair
from tests.analysis.fabricated import named
from tests.arms import CONFIG

CONSTANTS = CONFIG
SETTINGS = settings_of(CONSTANTS)
OF_MARGINS = CONFIG
TOUR = Tour(waypoints=((0.0, 0.0),), headings=4)
COUNT = CONFIG.sensitivity.combinations


def trial(
    moved_m: float, bystander_m: float, px: int, drift_m: float, to_navigable_m: float, clear_m: float, seen_px: int
) -> Trial:
    """A chair that was displaced by moved_m along x, and another that nobody was to move."""
    before, after = {"a": 0.0, "b": 5.0}, {"a": moved_m, "b": 5.0 + bystander_m}

    def sightings(places: dict[str, float]) -> tuple[Sighting, ...]:
        return tuple(Sighting(view=0, instance=name, px=px, x=x, z=0.0) for name, x in places.items())

    def world(places: dict[str, float]) -> WorldState:
        return WorldState(tuple(Instance(name, "Chair", x, 0.0) for name, x in places.items()))

    change = Alteration(kind="displace", instance="a", placement=(moved_m, 0.0), height_m=0.5)
    return Trial(
        candidate=Candidate(
            id="FloorPlan1/moved/0000",
            scene="FloorPlan1",
            relation=Relation.MOVED,
            category="Chair",
            target="a",
            distractor=None,
            tours=VisitPair(first=TOUR, second=TOUR),
            first=(),
            second=(change,),
            others={},
            spawn=Spawn(x=0.0, z=0.0, yaw_deg=0.0),
            refused=None,
        ),
        measured=TrialMeasurement(
            ended=None,
            displacement_m={"a": moved_m},
            spawn_clearance_m={"a": clear_m},
            spawn_free_moves=1,
            visible_px={0: seen_px},
            answer=(moved_m, 0.0),
            answer_to_navigable_m=to_navigable_m,
            sightings=VisitPair(first=sightings(before), second=sightings(after)),
            world_1=world(before),
            world_2=world(after),
            drift_m={"a": drift_m},
        ),
    )


trials = st.builds(
    trial,
    st.sampled_from([1.2, 1.4, 1.6, 2.5]),
    st.sampled_from([0.0, 0.6, 0.9, 1.4]),
    st.sampled_from([100, 200, 400, 900]),
    st.sampled_from([0.0, 0.2, 0.3, 0.6]),
    st.sampled_from([0.1, 0.7, 0.95, 1.2]),
    st.sampled_from([0.5, 1.2, 1.7, 2.5]),
    st.sampled_from([10, 70, 150, 900]),
)


def test_the_settings_are_every_combination_and_the_one_in_force():
    assert len(SETTINGS) == COUNT + 1 == 257
    seen = {tuple(one.items()) for one in CONFIG.sensitivity.settings()}
    assert len(seen) == COUNT
    assert SETTINGS[0] == CONSTANTS and all(one != CONSTANTS for one in SETTINGS[1:])


@given(trials)
def test_a_setting_admits_what_the_verdict_has_nothing_against(one):
    assert admitting(one, SETTINGS) == tuple(k for k, setting in enumerate(SETTINGS) if not any(reasons(one, setting)))


def test_a_trial_that_the_simulator_refused_is_admitted_by_none():
    one = trial(2.5, 0.0, 900, 0.0, 0.1, 2.5, 900)
    refused = one.model_copy(update={"measured": TrialMeasurement(ended=Rejection.SIMULATOR_ERROR)})
    assert admitting(refused, SETTINGS) == ()


admissions = st.lists(
    st.tuples(st.sets(st.integers(0, COUNT), min_size=1), st.booleans(), st.sampled_from([0.0, 1.0]), st.floats(0, 1)), max_size=8
)


@given(admissions)
def test_a_margin_is_the_mean_difference_over_those_that_its_setting_admits(drawn):
    given_ = [Admission(id=f"t{k}", settings=tuple(sorted(one[0])), released=one[1]) for k, one in enumerate(drawn)]
    rows = named(compute_margins(given_, [one[2] for one in drawn], [one[3] for one in drawn], OF_MARGINS))
    assert [row.setting for row in rows] == list(range(COUNT + 1)) and [row.in_force for row in rows] == [True] + [False] * COUNT
    for row in rows:
        here = [one for one in drawn if row.setting in one[0]]
        left = [one for one in here if one[1]]
        assert (row.episodes, row.released) == (len(here), len(left))
        for group, margin in ((here, row.margin), (left, row.released_margin)):
            assert (margin is None) == (not group)
            if group:
                assert margin == pytest.approx(np.mean([one[2] - one[3] for one in group]))
        if here:
            assert row.margin == pytest.approx(row.rate - row.baseline_rate)


@pytest.mark.parametrize("number", [COUNT + 1, 999])
def test_an_admission_by_a_setting_that_is_not_there_is_one_line(number):
    with pytest.raises(ValueError, match=f"the setting {number} does not exist; make the stage readmitted again"):
        compute_margins([Admission(id="t", settings=(number,), released=False)], [1.0], [0.0], OF_MARGINS)
