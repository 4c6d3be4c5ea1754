from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.navigation import navigation
from ovman.settings import Kind
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import embodied, static

ARMS = [
    ArmJob(name="answers", kind=Kind.STATIC, agent="x:y"),
    ArmJob(name="picks", kind=Kind.STATIC, agent="x:y", expected=True),
    ArmJob(name="driven", kind=Kind.EMBODIED, agent="x:y", executes="answers"),
    ArmJob(name="picked", kind=Kind.EMBODIED, agent="x:y", executes="picks"),
    ArmJob(name="alone", kind=Kind.EMBODIED, agent="x:y"),
]
EPISODES = st.lists(st.tuples(st.booleans(), st.booleans(), st.floats(0.01, 1)), min_size=1, max_size=40)


@given(EPISODES)
def test_lost_and_gained_are_the_way_from_static_to_embodied_success(episodes):
    outcomes = [static("answers", i, answered) for i, (answered, *_) in enumerate(episodes)]
    runs = [embodied("driven", i, run, spl=spl) for i, (_, run, spl) in enumerate(episodes)]
    *relations, whole = navigation(outcomes, runs, ARMS)
    assert whole.static_successes - whole.lost + whole.gained == whole.successes == sum(run for _, run, _ in episodes)
    for name in ("n", "successes", "lost", "gained"):
        assert getattr(whole, name) == sum(getattr(row, name) for row in relations)
    assert 0 <= whole.spl <= whole.sr
    if whole.successes:
        assert whole.spl_given_success == pytest.approx(whole.spl / whole.sr)
    else:
        assert whole.spl_given_success is None and whole.spl == 0


def test_an_expectation_has_no_successes_to_lose():
    outcomes = [static("picks", i, 0.25, "expected") for i in range(8)]
    (*_, whole) = navigation(outcomes, [embodied("picked", i, i == 0) for i in range(8)], ARMS)
    assert whole.static_successes == 2.0 and (whole.lost, whole.gained, whole.p) == (None, None, None)
    (*_, whole) = navigation(outcomes, [embodied("alone", i, True) for i in range(8)], ARMS)
    assert (whole.executes, whole.static_successes, whole.lost, whole.sr) == (None, None, None, 1.0)


def test_each_seed_has_its_rows():
    outcomes = [static("answers", i, True) for i in range(6)]
    runs = [embodied("driven", i, i >= seed, seed) for seed in (0, 2) for i in range(6)]
    assert [(row.seed, row.lost) for row in navigation(outcomes, runs, ARMS) if row.relation == "all"] == [(0, 0), (2, 2)]
