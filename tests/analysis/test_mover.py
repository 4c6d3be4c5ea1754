"""How far movers go follows from the episodes alone."""

from __future__ import annotations

import math

import pandas as pd
import pytest

from ovman.analysis.mover import AFTER, BETWEEN_VISITS, WALKS, WHILE_ACTING, MoverDistance, mover
from ovman.analysis.rows import read_rows
from ovman.records.episode import Episode
from ovman.report.tables.mover import mover_table
from tests.arms import CONFIG
from tests.episodes import DATA, released
from tests.task.test_episode import MOVED, moving

CORRIDOR_M = 2.5
"""The floor of the episode's mover: 26 points in a row, of which it is at the 21st."""


@pytest.fixture(scope="module")
def rows():
    return mover([Episode.from_json(moving()), Episode.from_json(MOVED)], 1.0, 1.5)


def test_a_mover_is_an_actions_steps_away_at_most_and_never_off_its_floor(rows):
    away = [row for row in rows if row.phase == WHILE_ACTING]
    assert [(row.actions, row.n) for row in away] == [(actions, WALKS) for actions in AFTER]
    for row in away:
        assert 0.0 <= row.least_m <= row.median_m <= row.greatest_m <= min(0.1 * row.actions, 2.0) + 1e-9
        assert row.within == 1.0 or row.greatest_m > row.radius_m
        assert row.moved is None
    assert away[0].greatest_m == 0.0 and away[-1].median_m > 0.0


def test_between_the_visits_it_is_displaced_as_the_worlds_say(rows):
    (row,) = (row for row in rows if row.phase == BETWEEN_VISITS)
    episode = Episode.from_json(moving())
    metres = math.dist(episode.world_1[episode.target].position, episode.world_2[episode.target].position)
    assert (row.n, row.actions, row.least_m, row.median_m, row.greatest_m) == (1, None, metres, metres, metres)
    assert (row.within, row.moved) == (float(metres <= 1.0), int(metres >= 1.5))


def test_the_rows_are_the_same_twice_and_none_without_a_mover(rows):
    assert mover([Episode.from_json(moving())], 1.0, 1.5) == rows
    assert mover([Episode.from_json(MOVED)], 1.0, 1.5) == []


def test_the_table_has_a_row_of_each_and_stands_without_any(rows):
    table = mover_table(pd.DataFrame(rows), CONFIG)
    assert len(table.rows) == 1 + len(AFTER) and "R is 1 m" in table.caption
    assert len(mover_table(pd.DataFrame(columns=list(rows[0].__slots__)), CONFIG).rows) == 0


def test_distances_of_the_release_follow_from_its_episodes():
    """Every walk is drawn from a stream of its own, the same again and again."""
    found = mover(released(), CONFIG.success.radius_m, CONFIG.candidates.delta_min_m)
    kept = read_rows(DATA / "metrics" / "mover.csv", MoverDistance)
    assert [(row.phase, row.actions, row.n, row.moved) for row in found] == [
        (row.phase, row.actions, row.n, row.moved) for row in kept
    ]
    for row, known in zip(found, kept, strict=True):
        for name in ("least_m", "median_m", "greatest_m", "radius_m", "within"):
            assert getattr(row, name) == pytest.approx(getattr(known, name), abs=1e-6)


def test_a_displacement_of_the_threshold_is_moved():
    episode = Episode.from_json(moving())
    metres = math.dist(episode.world_1[episode.target].position, episode.world_2[episode.target].position)
    counts = [mover([episode], 1.0, moved_m)[0].moved for moved_m in (metres, math.nextafter(metres, math.inf))]
    assert counts == [1, 0]


def test_the_floor_of_the_target_is_meant_whichever_mover_comes_first():
    episode = next(one for one in Episode.load(DATA / "episodes" / "everyday.jsonl") if len(one.movers) > 1)
    turned = episode.model_copy(update={"changes": episode.changes[::-1], "movers": episode.movers[::-1]})
    assert mover([turned], 1.0, 1.5) == mover([episode], 1.0, 1.5)
