"""Statements: the paper's own figures pass the test; the verdict follows from the figures that decide and from these alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import product

import pandas as pd
import pytest

from ovman.analysis.registry import compared
from ovman.report.metrics import Cell, Metrics, name_arms
from ovman.report.paper import COLUMNS, PAPER, TABLES
from ovman.report.results_page import list_arms, mark
from ovman.report.statements import NUMBERS, STATEMENTS, explain, judge
from ovman.report.statements.statement import FAILS, HOLDS, SOME, UNKNOWN, Evidence, Explanation, Group, Other, Readings
from ovman.settings import Kind
from tests.arms import CONFIG
from tests.episodes import DATA

ARMS = name_arms(CONFIG.comparisons, CONFIG.paper)
RELEASED_FILES = [DATA / "metrics" / f"{name}.csv" for name in compared(CONFIG)]
RELEASED = Metrics.load(RELEASED_FILES, ARMS)
RELEASED.rows = cache(RELEASED.rows)
EXTREMES = (-1000.0, 0.03, 1000.0)
each_statement = pytest.mark.parametrize("statement", STATEMENTS, ids=lambda statement: statement.key)


class Changed(Evidence):
    """Evidence in which a function replaces figures as they are shown. change: from index, label, cell, paper and decides."""

    def __init__(self, metrics: Metrics, change: Callable[[int, Cell, str, bool], Cell]) -> None:
        super().__init__(metrics, NUMBERS)
        self.change = change

    def use(self, label, cell, paper="", *, decides=True):
        return super().use(label, self.change(len(self.figures), cell, paper, decides), paper, decides=decides)


def holds(statement, change) -> bool:
    return bool(statement.test(Changed(RELEASED, change)))


def printed(key: str) -> float:
    """Return a figure of the paper: its value, or the middle of its range."""
    return (PAPER[key].low + PAPER[key].high) / 2


def paper_metrics() -> Metrics:
    """Return the released metrics with the rates and counts of the paper's tables in the place of ours."""
    rows: dict[str, list[dict[str, str | float]]] = {"static": [], "embodied": []}
    for kind in Kind:
        for _, arm, row in list_arms(CONFIG, kind):
            name = row.split(".")[1].replace("maintained", "one").removesuffix("_any").removesuffix("_nearest")
            for relation, rate in zip(COLUMNS, TABLES[kind][name], strict=False):
                others = dict.fromkeys(("successes", "n", "trials", "least", "greatest"), 0)
                rows[kind].append({"arm": arm, "relation": relation, "rate": rate, **others})
    frames = {f"{kind}_rates": pd.DataFrame(of_kind) for kind, of_kind in rows.items()}
    files = {path.stem: RELEASED.frame(path.stem) for path in RELEASED_FILES}
    return Metrics(files | frames, ARMS)


@each_statement
def test_the_papers_own_figures_pass_its_test(statement):
    """Only for statements of which the paper prints all figures that decide."""
    from_tables = ("memory_is_largest_on_the_past", "the_gain_is_where_an_object_is_left")
    evidence = Changed(paper_metrics(), lambda _, cell, paper, decides: Cell(printed(paper), "") if paper in PAPER else cell)
    result = statement.test(evidence)
    if statement.key in from_tables or all(figure.paper for figure in evidence.figures if figure.decides):
        assert result or not statement.about_paper


@each_statement
def test_its_verdict_flips_with_a_figure_that_decides(statement):
    evidence = Changed(RELEASED, lambda _, cell, paper, decides: cell)
    statement.test(evidence)
    deciding = [index for index, figure in enumerate(evidence.figures) if figure.decides]
    values = {*EXTREMES, *(float(evidence.figures[index].cell) for index in deciding)}
    changes = [dict.fromkeys(chosen, value) for chosen in ([index] for index in deciding) for value in values]
    # Where several tests must pass, all figures are set at once.
    changes += [dict(zip(deciding, chosen, strict=True)) for chosen in _spread(len(deciding), sorted(values))]
    found = set()
    for change in changes:
        found.add(holds(statement, lambda index, cell, paper, decides, change=change: Cell(change.get(index, cell), "")))
        if len(found) == 2:
            return
    raise AssertionError(f"always {found}")


def _spread(number: int, values: list[float]) -> Iterator[tuple[float, ...]]:
    """Yield values for a number of figures: all pairs of values in all patterns of up to seven figures."""
    for low, high in product(values, values):
        yield from product((low, high), repeat=number)


@each_statement
def test_figures_that_are_only_shown_decide_nothing(statement):
    known = {
        holds(statement, lambda _, cell, paper, decides, value=value: cell if decides else Cell(value, ""))
        for value in (*EXTREMES, float("nan"))
    }
    assert len(known) == 1


def test_every_cited_figure_of_the_paper_exists_and_our_own_statements_cite_none():
    assert len({statement.key for statement in STATEMENTS}) == len(STATEMENTS)
    assert sum(statement.about_paper for statement in STATEMENTS) == 53
    for statement in STATEMENTS:
        cited = [figure.paper for figure in judge(statement, RELEASED, NUMBERS).evidence.figures if figure.paper]
        assert {*cited} <= {*PAPER} and (statement.about_paper or not cited)


GROUP = Group("made up")


@GROUP.statement(
    "It helps.",
    holds_if="at least half",
    readings=Readings(
        "what helping is",
        "broad",
        {"narrow": Other({"static.broad": "static.narrow"}), "loose": Other(holds_if="at least a tenth")},
    ),
)
def it_helps(here):
    rate = here.use("success", here.rows("rates", arm="static.broad").one())
    here.explanation = Explanation(SOME, f"Doors: {rate}.", under=("broad", "loose"), episodes=("FloorPlan1/moved/0000",))
    return rate >= (0.1 if here.reading == "loose" else 0.5)


def judge_made_up(**rates: float):
    frame = pd.DataFrame([{"arm": name, "rate": rate} for name, rate in rates.items()])
    arms = {"static.broad": "broad", "static.narrow": "narrow"}
    return judge(it_helps, Metrics({"rates": frame} if rates else {}, arms), NUMBERS)


@pytest.mark.parametrize(("broad", "narrow"), list(product((0.05, 0.2, 0.8), repeat=2)))
def test_the_verdict_is_what_all_readings_agree_on(broad, narrow):
    judgement = judge_made_up(broad=broad, narrow=narrow)
    expected = {"broad": broad >= 0.5, "narrow": narrow >= 0.5, "loose": broad >= 0.1}
    assert tuple(judgement.readings) == ("broad", "narrow", "loose")
    assert judgement.under(HOLDS) == tuple(name for name in expected if expected[name])
    assert judgement.verdict is (HOLDS if all(expected.values()) else SOME if any(expected.values()) else FAILS)
    assert judgement.evidence.figures[0].cell == broad, "the figures shown are those of its own reading"


def test_a_reading_without_figures_decides_nothing_but_its_own_decides_all():
    there = judge_made_up(broad=0.8)
    assert there.verdict is HOLDS and there.readings["narrow"].verdict is UNKNOWN
    gone = judge_made_up(narrow=0.8)
    assert gone.verdict is UNKNOWN and gone.missing == "rates.csv has no row of broad"


def test_an_explanation_is_shown_only_below_the_verdict_that_it_was_written_for():
    two = judge_made_up(broad=0.8, narrow=0.2)
    assert mark(two) == "◐ holds under 2 of 3 readings only: broad, loose"
    assert explain(two) == "Doors: 0.800. (Looked at: `FloorPlan1/moved/0000`.) *Written by hand.*"
    for rates in ({"broad": 0.2, "narrow": 0.2}, {"broad": 0.8, "narrow": 0.8}, {"broad": 0.0, "narrow": 0.0}):
        note = explain(judge_made_up(**rates))
        assert (
            note is not None and "Doors" not in note and note.startswith("⚠ The explanation at hand was written when the verdict")
        )


def test_an_explanation_that_supposes_what_the_metrics_lack_is_left_out():
    group = Group("made up")

    @group.statement("It fails.", holds_if="never")
    def it_fails(here):
        rate = here.rows("rates", arm="a").one()
        here.explanation = Explanation(FAILS, f"Doors: {rate}.", given=rate > 0.5)
        return False

    def note(metrics: Metrics) -> str:
        return str(explain(judge(it_fails, metrics, {})))

    frames = {rate: Metrics({"rates": pd.DataFrame([{"arm": "a", "rate": rate}])}, {}) for rate in (0.6, 0.4)}
    assert note(frames[0.6]) == "Doors: 0.600. *Written by hand.*"
    assert "supposes figures that these metrics do not show" in note(frames[0.4])
