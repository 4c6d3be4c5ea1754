"""Explanations quote what was measured and are left out where it is not there or says something else; fabricated ones here."""

from __future__ import annotations

import re

import pytest

from ovman.analysis.registry import METRICS
from ovman.report.paper_comparison.explanations import Explanation, beside, read
from ovman.report.paper_comparison.page import OWN
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.statement import Judgement, Statement, Verdict, every, judged
from ovman.report.paper_comparison.statement import read as statements
from tests.report.paper_comparison.papers import metrics_of

PAPER, NUMBERS = Paper.read(), {"two_beat_one": 7}
STATEMENT = Statement.model_validate(
    {
        "key": "it_helps",
        "claim": "It helps.",
        "figures": {"rate": {"label": "success", "read": {"file": "rates", "where": {"arm": "a"}}}},
        "rule": "at least half",
        "holds": "rate >= 0.5",
    }
)
EXPLANATION = Explanation.model_validate(
    {
        "verdict": "holds",
        "text": "Of {rate} it makes {parts}, {twice} twice; the paper has {paper.static.two.all} (p {paper.handover_p:p}); "
        "see {number.two_beat_one}.",
        "measured": {
            "parts": {"label": "parts", "form": "expected", "read": {"file": "parts", "column": "parts", "where": {"arm": "a"}}},
            "twice": {"label": "twice", "form": "expected", "of": "2 * parts"},
        },
        "given": "parts < 2",
        "episodes": ["FloorPlan1/moved/0000"],
    }
)


def note(parts: str = "1.25", rate: str = "0.6", explanation: Explanation = EXPLANATION) -> str | None:
    files = {
        "rates": [{"arm": "a", "relation": "all", "rate": rate}],
        "parts": [{"arm": "a", "relation": "all", "parts": parts}],
    }
    return beside(judgement(rate), {"it_helps": explanation}, metrics_of(files), PAPER, NUMBERS)


def judgement(rate: str) -> Judgement:
    return judged(STATEMENT, metrics_of({"rates": [{"arm": "a", "relation": "all", "rate": rate}]}))


def test_figures_are_filled_in_as_the_page_writes_them():
    assert note() == (
        "Of 0.600 it makes 1.2, 2.5 twice; the paper has 0.416 (p 0.160); see 7. "
        "(Looked at: `FloorPlan1/moved/0000`.) *Written by hand.*"
    )
    assert "Of 0.700 it makes 1.5, 3.0 twice" in str(note("1.5", "0.7"))


def test_a_text_is_left_out_where_its_cause_is_not_measured_or_is_another():
    assert note("") == (
        "⚠ The explanation at hand quotes a figure that is not among the metrics (parts.csv (a, all): parts is empty), "
        "so it is left out."
    )
    assert note("3") == "⚠ The explanation at hand supposes that `parts < 2`, which these metrics do not show, so it is left out."
    assert "was written when the verdict was “holds”. Now it is “does not hold”" in str(note(rate="0.2"))


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{verdict: holds, text: 'a {cows}'}", "cows is no figure of the statement and none that is measured"),
        ("{verdict: holds, text: 'a {number.cows}'}", "number.cows is the number of no statement"),
        ("{verdict: holds, text: 'a {paper.cows}'}", "paper.cows is no figure of the paper"),
        ("{verdict: holds, text: a, measured: {x: {label: x, of: '1'}}}", "x is measured and never quoted"),
        ("{verdict: holds, text: 'a {two:cows}'}", "no figure is written as cows"),
        ("{verdict: holds, text: 'a {two'}", "expected '}'"),
        ("{verdict: holds, text: a, given: 'cows > 1'}", "cows is no figure of the statement"),
        ("{verdict: holds, text: a, given: 'two >'}", "is no expression"),
        ("{verdict: holds, text: a, under: [any]}", "under names readings where the verdict is"),
        ("{verdict: holds under some readings only, text: a}", "under names readings where the verdict is"),
        ("{verdict: holds under some readings only, text: a, under: [any]}", "any is no reading of the statement"),
    ],
)
def test_a_wrong_explanation_is_one_line(tmp_path, entry, said):
    path = tmp_path / "explanations.yaml"
    path.write_text(f"two_beat_one: {entry}\n", encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(said)) as caught:
        read(every(statements()), path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value) and "two_beat_one" in str(caught.value)


def test_explanations_measure_what_the_stage_is_given():
    given = {metric.name for metric in METRICS if metric.compared}
    for key, explanation in read(every((*statements(), *statements(OWN)))).items():
        for quantity in explanation.measured.values():
            reading = quantity.read
            while reading is not None:
                assert reading.file in given, key
                reading = reading.minus


def test_no_explanation_says_that_depth_and_poses_alone_differ_from_the_paper():
    """AI2-THOR's depth and poses are exact as well."""
    for key, explanation in read(every((*statements(), *statements(OWN)))).items():
        assert not re.search(r"(depth|poses) (is|are) exact here|depth without noise|exact depth", explanation.text), key


def test_verdicts_are_all_marked():
    from ovman.report.paper_comparison import page

    assert {page.mark(judgement("0.6")), page.mark(judgement("0.2"))} == {"✓\u00a0holds", "✗\u00a0does\u00a0not\u00a0hold"}
    assert page.mark(Judgement(STATEMENT, Verdict.UNKNOWN)) == "?\u00a0cannot\u00a0be\u00a0told"
