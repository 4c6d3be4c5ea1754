"""The life of an object: what is seen often settles, what is seen seldom goes, at the published keyframes."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.dualmap.local_map import Phase, Stage, advance, flush_frames, has_converged, is_stable
from tests.agents.dualmap.boxworld import CONSTANTS

LIFE = CONSTANTS.local_map.life


def life(stable: bool, unseen: int) -> list[Phase]:
    """The phases of an object through so many keyframes after the one that showed it last."""
    stage, phases = Stage(), []
    for missed in range(1, unseen + 1):
        stage = advance(stage, missed, stable, LIFE)
        phases.append(stage.phase)
        if stage.phase in (Phase.GONE, Phase.SETTLED):
            break
    return phases


def test_an_unstable_object_is_updated_for_ten_keyframes_pending_for_five_and_then_gone():
    assert life(stable=False, unseen=40) == [Phase.UPDATING] * 10 + [Phase.PENDING] * 5 + [Phase.GONE]


def test_a_stable_object_waits_for_five_keyframes_and_has_settled():
    assert life(stable=True, unseen=40) == [Phase.UPDATING] * 10 + [Phase.WAITING] * 5 + [Phase.SETTLED]


def test_the_empty_keyframes_at_the_end_are_as_many_as_a_life_has():
    assert flush_frames(LIFE) == 16 == len(life(stable=False, unseen=40))


@pytest.mark.parametrize("phase", [Phase.PENDING, Phase.WAITING, Phase.SETTLED])
def test_what_is_seen_again_is_updated_again_and_its_time_begins_anew(phase: Phase):
    assert advance(Stage(phase, 4), 0, True, LIFE) == Stage(Phase.UPDATING, 0)


def test_seven_observations_are_not_enough_and_eight_of_one_class_are():
    assert not is_stable([3] * 7, [0.9] * 7, 16, LIFE)
    assert is_stable([3] * 8, [0.9] * 8, 16, LIFE)


def test_the_majority_is_more_than_a_third():
    third, more = [0, 1, 2] * 4, [0, 1, 2] * 3 + [0, 0, 3]
    # Unsure observations of several classes leave the filter undecided, so that the majority alone counts.
    assert not is_stable(third, [0.1] * 12, 16, LIFE)
    assert is_stable(more, [0.1] * 12, 16, LIFE)


def test_without_a_majority_a_filter_that_has_come_to_rest_makes_an_object_stable():
    classes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9]
    sure = [0.3] * 9 + [0.95] * 3
    assert classes.count(9) * 3 <= len(classes)
    assert has_converged(classes + [9], sure + [0.95], 16, LIFE)
    assert is_stable(classes + [10, 11, 9], sure + [0.07, 0.07, 0.95], 16, LIFE)
    assert not is_stable(classes[:9], sure[:9], 16, LIFE)


def test_a_filter_that_has_just_changed_its_mind_has_not_converged():
    assert not has_converged([1, 2, 2], [0.9] * 3, 16, LIFE)
    assert not has_converged([1, 1], [0.99, 0.99], 16, LIFE)
    assert has_converged([1, 2, 2, 2, 2], [0.9] * 5, 16, LIFE)


def test_no_confidence_makes_a_filter_divide_by_zero():
    with np.errstate(divide="raise", invalid="raise"):
        assert has_converged([1] * 6, [1.0] * 6, 16, LIFE)
        has_converged([0, 1] * 400, [1.0, 0.0] * 400, 2, LIFE)
