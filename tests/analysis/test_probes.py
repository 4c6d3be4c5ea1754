"""The two-visit agent asked again: under other gates, with one past relation for the other, and under other thresholds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.probes import compute_margins, swap_relations, sweep_gates
from ovman.analysis.statistics import wilson_interval
from ovman.generation.readmission import settings_of
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Answer
from ovman.records.task import Relation
from ovman.records.trial import Admission
from tests.analysis.fabricated import named
from tests.arms import CONFIG
from tests.episodes import episode_record, released

NOTHING = Abstention(AbstentionReason.NO_CANDIDATE)


def test_a_gate_has_the_rate_of_the_answers_within_the_radius():
    episode = Episode.from_json(episode_record("moved", answer=(0.0, 0.0)))
    radius_m, far = CONFIG.success.radius_m, episode.model_copy(update={"id": "far"})

    def asked(one, _):
        return Answer(math.nextafter(radius_m, 9.0) if one.id == "far" else radius_m, 0.0)

    constants = CONFIG.with_values({"evaluation.confidence": 0.5})
    rows = named(sweep_gates([episode, far], asked, constants))
    assert [row.gate_m for row in rows] == sorted({*CONFIG.gate_sweep.gates_m, CONFIG.association.gate_m})
    for row in rows:
        low, high = wilson_interval(1, 2, 0.5)
        in_force = row.gate_m == CONFIG.association.gate_m
        assert (row.in_force, row.delta_min_m) == (in_force, CONFIG.candidates.delta_min_m)
        assert (row.n, row.successes, row.success, row.low, row.high, row.confidence) == (2, 1, 0.5, low, high, 0.5)


def test_a_relation_read_as_the_other_is_counted():
    removed = [one for one in released() if one.relation is Relation.REMOVED][:4]
    former = [one for one in released() if one.relation is Relation.FORMER][:1]
    late = {removed[0].id}

    def asked(episode, settings):
        assert settings is CONFIG
        if episode.id == removed[1].id:
            return NOTHING if episode.relation is Relation.REMOVED else Answer(*episode.answer)
        there = episode.answer if episode.id not in late or episode.relation is Relation.REMOVED else (99.0, 99.0)
        return Answer(*there)

    first, second = named(swap_relations([*removed, *former], asked, CONFIG))
    assert (first.relation, first.read_as, first.n) == (Relation.REMOVED, Relation.FORMER, 4)
    assert (first.answered, first.same, first.only_read_as) == (3, 2, 1)
    assert (first.successes, first.successes_read_as) == (3, 3)
    assert (second.n, second.answered, second.same, second.only_read_as) == (1, 1, 1, 0)
    assert swap_relations([], asked, CONFIG) == []


COUNT = CONFIG.sensitivity.combinations


def test_the_settings_are_every_combination_and_the_one_in_force():
    in_force, *others = settings_of(CONFIG)
    assert in_force == CONFIG and all(one != CONFIG for one in others)
    assert len(others) == COUNT == len({tuple(one.items()) for one in CONFIG.sensitivity.settings()})


admissions = st.lists(
    st.tuples(st.sets(st.integers(0, COUNT), min_size=1), st.booleans(), st.sampled_from([0.0, 1.0]), st.floats(0, 1)), max_size=8
)


@given(admissions)
def test_a_margin_is_the_mean_difference_over_those_that_its_setting_admits(drawn):
    given_ = [Admission(id=f"t{k}", settings=tuple(sorted(one[0])), released=one[1]) for k, one in enumerate(drawn)]
    rows = named(compute_margins(given_, [one[2] for one in drawn], [one[3] for one in drawn], CONFIG))
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
