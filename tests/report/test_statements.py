"""Statements: the paper's own figures pass the test; verdicts follow from the figures that decide and from resampled scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import product

import numpy as np
import pandas as pd
import pytest

from ovman.analysis.registry import compared
from ovman.analysis.statistics import draw_resamples
from ovman.report.metrics import Cell, Metrics, highest_of, lowest_of, mean_of, name_arms
from ovman.report.paper import PAPER
from ovman.report.results_page import mark
from ovman.report.statements import STATEMENTS, explain, judge
from ovman.report.statements.statement import (
    FAILS,
    HOLDS,
    SOME,
    UNDECIDED,
    UNKNOWN,
    Evidence,
    Explanation,
    Group,
    Margin,
    Other,
    Readings,
    above,
    at_least,
)
from ovman.settings import Kind
from tests.arms import CONFIG
from tests.episodes import DATA

ARMS = name_arms(CONFIG.comparisons, CONFIG.paper)
RELEASED_FILES = [DATA / "metrics" / f"{name}.csv" for name in compared(CONFIG)]
RELEASED = Metrics.load(RELEASED_FILES, ARMS)
RELEASED.rows = cache(RELEASED.rows)
SUMS, SUM_OF = {}, RELEASED.sums


def _sum_once(kind, arm, values="success", split="main", **where):
    """Sum outcomes once: the tests ask for the same sums thousands of times."""
    of = values if isinstance(values, str) else (values.name, values.to_numpy().tobytes())
    key = kind, arm, of, split, *sorted(where.items())
    if key not in SUMS:
        SUMS[key] = SUM_OF(kind, arm, values, split, **where)
    return SUMS[key]


RELEASED.sums = _sum_once
EXTREMES = (-1000.0, 0.03, 1000.0)
each_statement = pytest.mark.parametrize("statement", STATEMENTS, ids=lambda statement: statement.key)


class Changed(Evidence):
    """Evidence in which a function replaces figures as they are shown. change: from index, label, cell, paper and decides."""

    def __init__(self, metrics: Metrics, change: Callable[[int, Cell, str, bool], Cell]) -> None:
        super().__init__(metrics)
        self.change = change

    P = staticmethod(cache(lambda *asked: Evidence(RELEASED).p(*asked)))

    def p(self, kind, arm, baseline, relation="all", exact=None):
        return Changed.P(kind, arm, baseline, relation, exact)

    def use(self, label, cell, paper="", *, decides=True):
        return super().use(label, self.change(len(self.figures), cell, paper, decides), paper, decides=decides)


class OfPaper(Changed):
    """Evidence with the paper's figures in the place of ours: rates of its tables, and figures that it prints."""

    def __init__(self) -> None:
        super().__init__(RELEASED, lambda _, cell, paper, decides: Cell(printed(paper), "") if paper in PAPER else cell)

    def rate(self, kind, arm, relation="all", split="main", **where):
        if isinstance(relation, tuple):
            return mean_of([self.rate(kind, arm, one, split, **where) for one in relation])
        key = f"{arm.replace('maintained', 'one')}.{relation}"
        of_paper = key in PAPER and split == "main" and not where
        return Cell(printed(key), key) if of_paper else super().rate(kind, arm, relation, split, **where)


def margins_of(statement, evidence: Evidence) -> list[Margin]:
    claimed = statement.test(evidence)
    return [claimed] if isinstance(claimed, Margin) else list(claimed)


def holds(statement, change) -> bool:
    return all(margin.holds for margin in margins_of(statement, Changed(RELEASED, change)))


def printed(key: str) -> float:
    """Return a figure of the paper: its value, or the middle of its range."""
    return (PAPER[key].low + PAPER[key].high) / 2


@each_statement
def test_the_papers_own_figures_pass_its_test(statement):
    """Only for statements of which the paper prints all figures that decide."""
    from_tables = ("memory_is_largest_on_the_past", "the_gain_is_where_an_object_is_left", "same_maps_read_twice")
    evidence = OfPaper()
    result = all(margin.holds for margin in margins_of(statement, evidence))
    if statement.key in from_tables or all(figure.paper in PAPER for figure in evidence.figures if figure.decides):
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
        found.add(holds(statement, lambda index, cell, paper, decides, change=change: Cell(change.get(index, cell), "changed")))
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


@each_statement
def test_its_verdict_is_that_of_its_own_figures_in_most_resamples(statement):
    """A verdict that is not open agrees with the figures that the page shows."""
    judgement = judge(statement, RELEASED)
    by_figures = all(margin.holds for margin in judgement.margins)
    if judgement.verdict in (HOLDS, FAILS):
        assert by_figures == (judgement.verdict is HOLDS)
    if judgement.verdict is UNDECIDED and statement.readings is None:
        assert judgement.share is not None and 0.1 < judgement.share < 0.9


def test_every_cited_figure_of_the_paper_exists_and_our_own_statements_cite_none():
    assert len({statement.key for statement in STATEMENTS}) == len(STATEMENTS)
    for statement in STATEMENTS:
        cited = [figure.paper for figure in judge(statement, RELEASED).evidence.figures if figure.paper]
        assert {*cited} <= {*PAPER} and (statement.about_paper or not cited)
    assert 20 <= sum(statement.is_listed for statement in STATEMENTS) <= 25


@each_statement
def test_an_explanation_called_measured_shows_a_measurement_that_is_not_the_verdicts_own(statement):
    judgement = judge(statement, RELEASED)
    explanation = judgement.evidence.explanation
    if explanation is not None:
        deciding = {figure.cell.source for figure in judgement.evidence.figures if figure.decides}
        assert (explanation.label == "measured") == bool(explanation.measured)
        for cell in explanation.measured:
            assert ".csv" in cell.source and cell.source not in deciding and f"{cell}" in explanation.text


# --- resampled scenes -----------------------------------------------------------------------------


def test_resampled_rates_are_those_of_resampled_outcomes():
    sums = RELEASED.sums(Kind.STATIC, "static.two", relation="moved")
    frame = pd.read_csv(DATA / "metrics" / "main" / "static_outcomes.csv")
    scenes = sorted(frame["scene"].unique())
    of_arm = frame[(frame["arm"] == "two_visits") & (frame["relation"] == "moved")]
    assert sums.mean() == pytest.approx(of_arm["success"].mean())
    for weights, draw in list(zip(draw_resamples(len(scenes), "main"), sums.mean().draws, strict=True))[:20]:
        drawn = pd.concat(
            [of_arm[of_arm["scene"] == scene] for scene, times in zip(scenes, weights, strict=True) for _ in range(times)]
        )
        assert draw == pytest.approx(drawn["success"].mean())


def test_a_p_in_a_resample_is_that_of_its_wins_and_losses():
    from ovman.analysis.statistics import holm, mcnemar_exact

    evidence = Evidence(RELEASED)
    frame = pd.read_csv(DATA / "metrics" / "main" / "embodied_outcomes.csv")
    frame = frame[frame["seed"] == 0]
    scenes = sorted(frame["scene"].unique())
    ours, theirs = (frame[frame["arm"] == f"{name}_visit{s}_embodied"] for name, s in (("two", "s"), ("single", "")))
    both = ours.merge(theirs, on="episode")
    p = evidence.p(Kind.EMBODIED, "embodied.two", "embodied.one", "former")
    for number, weights in enumerate(draw_resamples(len(scenes), "main")[:5]):
        of_relation = []
        for relation in ("moved", "former", "moving", "stable", "appeared", "removed"):
            rows = both[both["relation_x"] == relation]
            times = rows["scene_x"].map(dict(zip(scenes, weights, strict=True)))
            wins, losses = ((times * (sign * (rows["success_x"] - rows["success_y"]) > 0)).sum() for sign in (1, -1))
            of_relation.append(mcnemar_exact(int(wins), int(losses)))
        assert p.draws[number] == pytest.approx(holm(of_relation)[1])


def resampled(*draws: float) -> Cell:
    return Cell(0.5, "made up", draws=np.array(draws))


def test_numbers_keep_their_resamples():
    a, b = resampled(0.0, 1.0), resampled(1.0, 0.5)
    assert (a - b).draws.tolist() == [-1.0, 0.5] and (a - Cell(0.25, "")).draws.tolist() == [-0.25, 0.75]
    assert lowest_of([a, b, Cell(0.7, "")]).draws.tolist() == [0.0, 0.5]
    assert highest_of([a, b]).draws.tolist() == [1.0, 1.0] and mean_of([a, b]).draws.tolist() == [0.5, 0.75]
    assert (Cell(1.0, "") - Cell(0.5, "")).draws is None and lowest_of([Cell(1.0, "")]).draws is None


def test_a_share_of_few_things_is_not_certain():
    rows = pd.DataFrame([{"hits": 0, "n": 9}, {"hits": 50, "n": 100}])
    none, half = (Evidence(RELEASED).share(Metrics({"a": rows[k : k + 1]}, {}).rows("a"), "hits", "n") for k in range(2))
    assert none == 0.0 and np.quantile(none.draws, 0.95) > 0.1
    assert half == 0.5 and half.draws.std() == pytest.approx(0.05, abs=0.005)


def judge_share(*margins: Margin):
    group = Group("made up")
    return judge(group.statement("It.", holds_if="so")(lambda here: margins), RELEASED)


@pytest.mark.parametrize(
    ("positive", "verdict"), [(10, HOLDS), (9, HOLDS), (8, UNDECIDED), (5, UNDECIDED), (2, UNDECIDED), (1, FAILS)]
)
def test_a_claim_is_undecided_where_neither_side_has_nine_tenths(positive, verdict):
    judgement = judge_share(above(resampled(*[1.0] * positive, *[-1.0] * (10 - positive)), 0.0))
    assert judgement.verdict is verdict and judgement.share == positive / 10


def test_all_margins_must_hold_in_the_same_resample_and_equal_numbers_are_at_least_but_not_above():
    assert judge_share(above(resampled(1, 1, -1, -1), 0.0), above(resampled(-1, -1, 1, 1), 0.0)).verdict is FAILS
    zero = resampled(0.0, 0.0)
    assert judge_share(at_least(zero, 0.0)).verdict is HOLDS and judge_share(above(zero, 0.0)).verdict is FAILS
    assert judge_share(at_least(resampled(1.0), 0.0), above(Cell(-1.0, ""), 0.0)).verdict is FAILS, "a margin without resamples"


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
    here.explanation = Explanation(SOME, f"Doors: {rate}.", under=("broad", "loose"))
    return at_least(rate, 0.1 if here.reading == "loose" else 0.5)


def judge_made_up(**rates: float):
    frame = pd.DataFrame([{"arm": name, "rate": rate} for name, rate in rates.items()])
    arms = {"static.broad": "broad", "static.narrow": "narrow"}
    return judge(it_helps, Metrics({"rates": frame} if rates else {}, arms))


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
    assert mark(two) == "◐\u00a0depends\u00a0on\u00a0the\u00a0reading: holds by broad, loose"
    assert explain(two) == "Doors: 0.800. *(Conjecture.)*"
    assert "Doors" not in str(explain(judge_made_up(broad=0.0, narrow=0.0))), "it fails, which is another verdict"
    assert explain(judge_made_up(broad=0.8, narrow=0.8)) is None, "a claim that holds needs no reason"


def test_an_explanation_that_supposes_what_the_metrics_lack_is_left_out():
    group = Group("made up")

    @group.statement("It fails.", holds_if="never")
    def it_fails(here):
        rate = here.rows("rates", arm="a").one()
        here.explanation = Explanation(FAILS, f"Doors: {rate}.", given=rate > 0.5)
        return above(Cell(-1.0, ""), 0.0)

    def note(metrics: Metrics) -> str:
        return str(explain(judge(it_fails, metrics)))

    frames = {rate: Metrics({"rates": pd.DataFrame([{"arm": "a", "rate": rate}])}, {}) for rate in (0.6, 0.4)}
    assert note(frames[0.6]) == "Doors: 0.600. *(Conjecture.)*"
    assert "supposes figures that these metrics do not show" in note(frames[0.4])


@pytest.mark.parametrize("source", ["rates.csv (a): rate", ""])
def test_a_figure_of_the_verdict_is_refused_as_a_measurement_of_its_cause(source):
    group = Group("made up")

    @group.statement("It fails.", holds_if="never")
    def it_fails(here):
        rate = here.use("success", here.rows("rates", arm="a").one())
        here.explanation = Explanation(FAILS, f"Doors: {rate}.", measured=(Cell(rate, source),))
        return above(rate, 1.0)

    metrics = Metrics({"rates": pd.DataFrame([{"arm": "a", "rate": 0.5}])}, {})
    with pytest.raises(ValueError, match="does not measure the cause"):
        judge(it_fails, metrics)
