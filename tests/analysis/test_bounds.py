"""The table of bounds: what an agent that ignores a part of the query can reach, by counting queries of one world pair."""

from __future__ import annotations

import pytest

from ovman.analysis.bounds import BOUNDS, bounds
from ovman.analysis.outcomes import count_alike, static_outcomes
from ovman.analysis.rows import write_csv
from ovman.records.prediction import Answer, Prediction
from ovman.records.task import Relation
from ovman.report.tables import TABLES
from ovman.report.tables.table import make_table, read_metrics
from tests.arms import CONFIG
from tests.episodes import released

KINDS = ((Relation.MOVED, "Chair"), (Relation.MOVED, "Stool"), (Relation.FORMER, "Chair"))
ASKED = [next(e for e in released() if (e.relation, e.category) == kind) for kind in KINDS]


def paired(pair="world"):
    return [episode.model_copy(update={"pair": pair}) for episode in ASKED]


def rows(episodes, arm, right):
    """The rows of an arm that is right on the episodes of these numbers."""
    made = [
        Prediction.of(one.id, arm, 0, Answer(one.answer[0] + 9.0 * (k not in right), one.answer[1]), None)
        for k, one in enumerate(episodes)
    ]
    found = bounds(static_outcomes(episodes, made, radius_m=1.0), episodes, CONFIG.arms, 0.95)
    return {(row["by"], row["group"]): row for row in found}


def test_the_bounds_count_the_queries_of_a_pair():
    episodes = paired()
    assert list(count_alike(episodes).values()) == [2, 2, 1]
    found = rows(episodes, "largest_box", {0})
    assert found["relation", Relation.MOVED]["bound"] == pytest.approx(1 / 2)
    assert found["relation", Relation.FORMER]["bound"] == 1.0
    assert found["relation", "all"]["inverse_k"] == pytest.approx((1 / 2 + 1 + 1 / 2) / 3)
    assert found["category", "Chair"]["rate"] == pytest.approx(1 / 2)
    assert found["relation", Relation.MOVED]["within"] is True
    assert rows(episodes, "largest_box", {0, 1})["relation", Relation.MOVED]["within"] is False
    of_relation = rows(episodes, "layout_prior", {0, 1, 2})["relation", "all"]
    assert of_relation["bound"] == of_relation["inverse_k"] and of_relation["excess"] > 0


def test_without_pairs_changes_alike_count_and_nothing_bounds_what_ignores_the_relation():
    assert list(count_alike(ASKED).values()) == [len(one.alike) for one in ASKED]
    row = rows(ASKED, "layout_prior", set())["relation", "all"]
    assert row["bound"] is None and row["within"] is None
    assert rows(ASKED, "true_first_visit", set())["relation", "all"]["bound"] == row["inverse_n"]


def test_pairs_are_counted_apart_and_agents_that_are_blind_to_nothing_are_left_out():
    episodes = paired()[:1] + [paired("other")[1]] + paired()[2:]
    assert list(count_alike(episodes).values()) == [1, 1, 1]
    assert rows(episodes, "two_visits", {0}) == {}


def test_the_table_names_the_relations_in_which_a_bound_is_exceeded(tmp_path):
    of_pair = [*rows(paired(), "largest_box", {0, 1}).values(), *rows(paired(), "layout_prior", set()).values()]
    write_csv(tmp_path / "bounds.csv", BOUNDS, of_pair)
    cells = make_table(TABLES["bounds"], read_metrics(tmp_path / "bounds.csv"), CONFIG).cells("md")
    assert cells["system"].tolist() == ["1/m", "largest box", "1/k", "layout prior"]
    assert cells["beyond"].tolist()[1] == "MOVED" and cells["beyond"].tolist()[3] == "none"


def test_without_an_agent_that_is_blind_to_something_the_table_is_empty(tmp_path):
    write_csv(tmp_path / "bounds.csv", BOUNDS, [])
    assert not make_table(TABLES["bounds"], read_metrics(tmp_path / "bounds.csv"), CONFIG).groups
