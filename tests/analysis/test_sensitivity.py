"""Admissibility under other thresholds: whom each setting admits, and the margins over whom it admits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.probes import compute_margins
from ovman.generation.readmission import settings_of
from ovman.records.trial import Admission
from tests.analysis.fabricated import named
from tests.arms import CONFIG

CONSTANTS = CONFIG
SETTINGS = settings_of(CONSTANTS)
OF_MARGINS = CONFIG
COUNT = CONFIG.sensitivity.combinations


def test_the_settings_are_every_combination_and_the_one_in_force():
    assert len(SETTINGS) == COUNT + 1 == 257
    seen = {tuple(one.items()) for one in CONFIG.sensitivity.settings()}
    assert len(seen) == COUNT
    assert SETTINGS[0] == CONSTANTS and all(one != CONSTANTS for one in SETTINGS[1:])


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
