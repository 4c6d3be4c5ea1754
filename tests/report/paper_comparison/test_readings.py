"""Claims that depend on a definition are judged under each of its readings; a fabricated one here."""

from __future__ import annotations

from itertools import product

import pytest
from pydantic import ValidationError

from ovman.report.paper_comparison import page
from ovman.report.paper_comparison.explanations import Explanation, beside
from ovman.report.paper_comparison.metrics import Reading
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.statement import Statement, Verdict, every, judged, read
from tests.arms import CONFIG
from tests.report.paper_comparison.papers import metrics_of

NAMES = ("broad", "narrow", "loose")
STATEMENT = Statement.model_validate(
    {
        "key": "it_helps",
        "claim": "It helps.",
        "figures": {"rate": {"label": "success", "read": {"file": "rates", "where": {"arm": "arm_broad"}}}},
        "rule": "at least half",
        "holds": "rate >= 0.5",
        "readings": {
            "definition": "what helping is",
            "own": "broad",
            "others": {
                "narrow": {"arms": {"arm_broad": "arm_narrow"}},
                "loose": {"rule": "at least a tenth", "holds": "rate >= 0.1"},
            },
        },
    }
)
PAPER = Paper.read()


def metrics(**rates: float):
    return metrics_of({"rates": [{"arm": f"arm_{name}", "relation": "all", "rate": str(rate)} for name, rate in rates.items()]})


@pytest.mark.parametrize(("broad", "narrow"), list(product((0.05, 0.2, 0.8), repeat=2)))
def test_the_verdict_is_what_all_readings_agree_on(broad, narrow):
    judgement = judged(STATEMENT, metrics(broad=broad, narrow=narrow))
    holds = {"broad": broad >= 0.5, "narrow": narrow >= 0.5, "loose": broad >= 0.1}
    assert tuple(judgement.readings) == NAMES
    assert judgement.under(Verdict.HOLDS) == tuple(name for name in NAMES if holds[name])
    expected = Verdict.HOLDS if all(holds.values()) else Verdict.SOME if any(holds.values()) else Verdict.FAILS
    assert judgement.verdict is expected
    assert judgement.cells["rate"].value == broad, "the figures shown are those of its own reading"
    assert judgement.readings["narrow"].cells["rate"].source == "rates.csv (arm_narrow, all): rate"


def test_a_reading_that_cannot_be_told_decides_nothing_but_its_own_decides_all():
    there = judged(STATEMENT, metrics(broad=0.8))
    assert there.verdict is Verdict.HOLDS and there.readings["narrow"].verdict is Verdict.UNKNOWN
    gone = judged(STATEMENT, metrics(narrow=0.8))
    assert gone.verdict is Verdict.UNKNOWN and gone.missing == "rates.csv has no row of arm_broad, all"


def test_the_page_names_the_readings_under_which_a_claim_holds():
    one, two = judged(STATEMENT, metrics(broad=0.2, narrow=0.2)), judged(STATEMENT, metrics(broad=0.8, narrow=0.2))
    assert page.mark(one) == "◐ holds under one reading only: loose"
    assert page.mark(two) == "◐ holds under 2 of 3 readings only: broad, loose"
    assert str(page.readings_of(two)).splitlines() == [
        "It depends on a definition: what helping is.",
        "",
        "- ✓ *broad* – holds: success 0.800",
        "- ✗ *narrow* – does not hold: success 0.200",
        "- ✓ *loose* – holds: success 0.800",
    ]
    assert "- ? *narrow* – cannot be told: rates.csv has no row" in str(page.readings_of(judged(STATEMENT, metrics(broad=0.8))))


def test_an_explanation_belongs_to_the_readings_it_was_written_under():
    two = judged(STATEMENT, metrics(broad=0.8, narrow=0.2))
    for under, shown in ((("broad", "loose"), True), (("loose", "broad"), True), (("loose",), False)):
        explained = {"it_helps": Explanation(verdict=Verdict.SOME, under=under, text="Doors.")}
        note = beside(two, explained, metrics(), PAPER, {})
        assert note is not None and ("Doors." in note) is shown and ("⚠" in note) is not shown
    assert beside(two, {}, metrics(), PAPER, {}) == "No explanation yet: the frames have not been inspected."


def test_other_arms_take_the_place_of_all_of_a_figure():
    reading = Reading(file="a", where={"arm": "x", "baseline": ("x", "z")}, minus=Reading(file="a", where={"arm": "x"}))
    other = reading.of_arms({"x": "y"})
    assert other.where == {"arm": "y", "baseline": ("y", "z")} and other.minus == Reading(file="a", where={"arm": "y"})
    assert reading.of_arms({}) == reading


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ({"definition": "a", "own": "b", "others": {}}, "at least 1"),
        ({"definition": "a", "own": "b", "others": {"b": {"arms": {"x": "y"}}}}, "b is the name of two readings"),
        ({"definition": "a", "own": "b", "others": {"c": {}}}, "other arms or another test"),
        ({"definition": "a", "own": "b", "others": {"c": {"holds": "rate > 0"}}}, "both rule and holds"),
        ({"definition": "a", "own": "b", "others": {"c": {"rule": "a", "holds": "rate >"}}}, "is no expression"),
    ],
)
def test_wrong_readings_are_refused(readings, said):
    with pytest.raises(ValidationError, match=said):
        Statement.model_validate(STATEMENT.model_dump() | {"readings": readings})


def test_every_reading_of_the_statements_reads_arms_that_are_there():
    rows = {f"static.{row}" for row in CONFIG.paper.static.values()} | {
        f"embodied.{row}" for row in CONFIG.paper.embodied.values()
    }
    hanging = [statement for statement in every(read()) if statement.readings is not None]
    assert hanging
    for statement in hanging:
        assert statement.readings is not None
        for name, other in statement.readings.others.items():
            assert {*other.arms, *other.arms.values()} <= rows, name
            assert statement.under(other).figures != statement.figures or other.holds, f"{statement.key}: {name} changes nothing"
