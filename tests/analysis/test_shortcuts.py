"""What the category alone is worth: the arms beside 1/n, computed twice by different ways, and the split by crowding."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from ovman.agents import category_only
from ovman.analysis import frames
from ovman.analysis.outcomes import Case, static_outcomes
from ovman.analysis.shortcuts import Shortcut, shortcuts
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.task import Relation, WorldState
from ovman.report.tables.shortcuts import OTHERS, shortcuts_table
from ovman.report.tables.table import SECTION, markdown
from ovman.settings import Kind
from ovman.task import category_pick
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG
from tests.episodes import released

EPISODES = released()
CASES = [Case.of(episode) for episode in EPISODES]
WIDE_M = 3.0
"""A radius within which released answers have neighbours: within R of the success test none has."""
RADIUS_M = CONFIG.success.radius_m
ARMS = dict(
    zip(CONFIG.comparisons.shortcuts, (category_only.predict_answers_visit, category_only.predict_second_visit), strict=True)
)


@dataclass(frozen=True)
class Truth:
    """A context in which all that is there was recorded."""

    episode: Episode

    def world(self, which: str) -> WorldState:
        return self.episode.world_1 if which == "first" else self.episode.world_2


def outcomes(radius_m=RADIUS_M):
    records = [
        Prediction.of(episode.id, arm, 0, predict(episode.query, Truth(episode))[0])
        for arm, predict in ARMS.items()
        for episode in EPISODES
    ]
    return static_outcomes(CASES, records, radius_m=radius_m, samples=1, seed=0)


ROWS = shortcuts(CASES, outcomes(), [], RADIUS_M)


def test_a_pick_of_the_category_is_what_counting_the_instances_near_the_answer_gives():
    for row in ROWS:
        episodes = [e for e in EPISODES if row.relation in (e.relation.value, "all")]
        first = row.arm == next(iter(ARMS))
        picks = [
            category_pick(e.world_1 if first and e.relation.past else e.world_2, e.query, e.answer, RADIUS_M) for e in episodes
        ]
        assert row.n == len(episodes) and row.rate == pytest.approx(sum(picks) / len(picks))
        assert row.chance == pytest.approx(sum(1 / e.instances_in_category for e in episodes) / len(episodes))
        assert row.excess == pytest.approx(row.rate - row.chance)


def test_on_uncrowded_episodes_the_pick_is_at_chance_or_finds_nothing():
    for row in ROWS:
        past = row.relation in (r.value for r in Relation if r.past)
        if row.arm != next(iter(ARMS)) and past:
            assert row.uncrowded_rate == 0.0
        elif row.relation != "all":
            uncrowded = [c for c in CASES if c.relation == row.relation and (c.neighbour_m is None or c.neighbour_m > RADIUS_M)]
            assert row.uncrowded_rate == pytest.approx(sum(1 / c.instances for c in uncrowded) / len(uncrowded))
            assert row.crowded == row.n - len(uncrowded)


def test_crowded_and_uncrowded_make_the_whole_and_a_part_without_episodes_has_no_rate():
    for row in ROWS:
        parts = [(row.crowded, row.crowded_rate), (row.n - row.crowded, row.uncrowded_rate)]
        assert all((rate is None) == (n == 0) for n, rate in parts)
        assert sum(n * (rate or 0.0) for n, rate in parts) == pytest.approx(row.n * row.rate)
    none = shortcuts(CASES, outcomes(), [], 0.0)
    assert all(row.crowded == 0 and row.crowded_rate is None and row.uncrowded_rate == row.rate for row in none)


def test_neighbours_are_those_of_the_answers_visit_and_of_the_second():
    for episode, case in zip(EPISODES, CASES, strict=True):
        worlds = (episode.world_1, episode.world_2) if episode.relation.past else (episode.world_2,)
        away = [math.dist(k.position, episode.answer) for world in worlds for k in world if k.id != episode.target]
        assert case.neighbour_m == (min(away) if away else None)


def test_a_neighbour_at_the_radius_makes_an_episode_crowded():
    answers = [static("answers", 6 * k, k < 2, instances=2 + 2 * (k % 2)) for k in range(4)]
    near = [RADIUS_M, math.nextafter(RADIUS_M, math.inf), None, math.nextafter(RADIUS_M, math.inf)]
    cases = [
        Case(a.episode, a.scene, a.relation, "Chair", 2, (0.0, 0.0), neighbour_m=m) for a, m in zip(answers, near, strict=True)
    ]
    runs = [embodied("drives", 6 * k, False) for k in range(4)]
    assert shortcuts(cases, answers, runs, RADIUS_M) == [
        Shortcut(kind, arm, relation, 4, chance, rate, rate - chance, 1, of_crowded, of_others)
        for kind, arm, chance, rate, of_crowded, of_others in (
            (Kind.STATIC, "answers", 0.375, 0.5, 1.0, 1 / 3),
            (Kind.EMBODIED, "drives", 0.5, 0.0, 0.0, 0.0),
        )
        for relation in ("moved", "all")
    ]


def test_embodied_arms_follow_and_a_stranger_is_named():
    runs = [embodied("cow", number, number % 3 == 0, seed) for number in range(6) for seed in (0, 1)]
    cases = [Case(run.episode, run.scene, run.relation, "Chair", 2, (0.0, 0.0), neighbour_m=0.5) for run in runs]
    rows = shortcuts(cases, [], runs, RADIUS_M)
    assert {row.kind for row in rows} == {Kind.EMBODIED} and rows[-1].n == 6 and rows[-1].rate == pytest.approx(2 / 6)
    assert rows[-1].crowded == 6 and rows[-1].uncrowded_rate is None
    with pytest.raises(ValueError, match="not among the episodes"):
        shortcuts(cases[2:], [], runs, RADIUS_M)


def test_the_table_sets_the_picks_by_relation_above_all_arms_and_says_when_nothing_is_crowded():
    made = shortcuts_table(frames.frame_of(Shortcut, ROWS), CONFIG)
    assert len(made.rows) == 2 * 7 + 2 and made.rows[SECTION].eq(OTHERS).sum() == 2
    crowded = shortcuts_table(frames.frame_of(Shortcut, shortcuts(CASES, outcomes(WIDE_M), [], WIDE_M)), CONFIG)
    assert "stands apart" in crowded.caption and "+0.1" in markdown(crowded)
    none = shortcuts_table(frames.frame_of(Shortcut, shortcuts(CASES, outcomes(), [], 0.0)), CONFIG)
    assert "no such episode is left" in none.caption
    assert len(shortcuts_table(frames.frame_of(Shortcut, []), CONFIG).rows) == 0
